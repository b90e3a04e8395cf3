"""Variables of the node's process and of its children; needs no ROS."""

from __future__ import annotations

import os
import sys
from xml.etree import ElementTree

import pytest

from risorius_ros import environment


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "environ", {"HOME": "/home/nobody"})


def test_prepare_sets_the_dds_profile_and_one_blas_thread(bare: None) -> None:
    environment.prepare()
    assert os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] == str(environment.DDS_PROFILE)
    assert os.environ["FASTDDS_DEFAULT_PROFILES_FILE"] == str(environment.DDS_PROFILE)
    assert os.environ["OPENBLAS_NUM_THREADS"] == "1"


def test_prepare_leaves_the_user_s_choice_alone(bare: None) -> None:
    mine = {"FASTDDS_DEFAULT_PROFILES_FILE": "mine.xml", "OMP_NUM_THREADS": "4"}
    os.environ.update(mine)
    environment.prepare()
    assert mine.items() <= os.environ.items()
    assert not {"FASTRTPS_DEFAULT_PROFILES_FILE", "OPENBLAS_NUM_THREADS"} & os.environ.keys()


def test_the_profile_has_room_for_a_frame_of_50_000_vertices() -> None:
    name = "{http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles}"
    profile = ElementTree.parse(environment.DDS_PROFILE)
    sizes = [
        int(element.text or "0") for tag in ("segment_size", "maxMessageSize") for element in profile.iter(name + tag)
    ]
    assert len(sizes) == 2
    assert min(sizes) > 12 * 50_000


def test_a_child_does_not_inherit_what_the_wheels_set_for_this_interpreter(bare: None) -> None:
    os.environ["_ROS_WHEELS_BOOTSTRAP_COMPLETE"] = "1"
    os.environ["LD_LIBRARY_PATH"] = f"{sys.prefix}/lib:/opt/mine/lib"
    child = environment.of_child()
    assert "_ROS_WHEELS_BOOTSTRAP_COMPLETE" not in child
    assert child["LD_LIBRARY_PATH"] == "/opt/mine/lib"


def test_a_sourced_ros_keeps_its_library_path(bare: None) -> None:
    os.environ["LD_LIBRARY_PATH"] = "/opt/ros/jazzy/lib"
    assert environment.of_child()["LD_LIBRARY_PATH"] == "/opt/ros/jazzy/lib"
