"""Start the node where a ROS 2 is sourced: ros2 launch risorius_ros face_engine.launch.py model_path:=face.h5."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = (
    ("model_path", None, str, "Reduced model to evaluate (HDF5), from `risorius train`."),
    ("frame_id", "face", str, "Frame of the published vertices."),
    ("preview", "false", bool, "Serve a page that shows the face and has sliders."),
    ("preview_port", "0", int, "Port of that page; 0 takes a free one."),
)


def generate_launch_description() -> LaunchDescription:
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, default, _, description in ARGUMENTS
    ]
    parameters = {name: ParameterValue(LaunchConfiguration(name), value_type=kind) for name, _, kind, _ in ARGUMENTS}
    node = Node(package="risorius_ros", executable="face_engine", parameters=[parameters], output="screen")
    return LaunchDescription([*declared, node])
