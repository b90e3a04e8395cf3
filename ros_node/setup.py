"""Build of the ROS 2 package by colcon; pip installs the same modules from the project's root."""

from setuptools import setup

NAME = "risorius_ros"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    package_data={NAME: ["py.typed", "*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["../launch_scripts/face_engine.launch.py"]),
    ],
    install_requires=["setuptools", "risorius"],
    zip_safe=False,
    maintainer="The Risorius authors",
    maintainer_email="risorius@users.noreply.github.com",
    description="Facial action units in, a physically deformed face out: the node of Risorius.",
    license="BSD-3-Clause",
    entry_points={"console_scripts": ["face_engine = risorius_ros.__main__:main"]},
)
