"""ROS 2: action unit weights in, deformed face meshes out."""
