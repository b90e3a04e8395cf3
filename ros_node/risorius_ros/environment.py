"""Environment variables of the node's process and of processes that it or the demo start."""

from __future__ import annotations

import os
import sys
from pathlib import Path

DDS_PROFILE = Path(__file__).with_name("fastdds.xml")
_DDS_VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_BLAS_VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
_BOOTSTRAP_MARK = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"


def prepare() -> None:
    """Set what Fast DDS and BLAS read once; call it before numpy is imported and before `rclpy.init`.

    The profile lets frames over 512 KiB through. BLAS gets one thread: waking a second one costs more than a
    matrix-vector product takes. What the user set is left alone.
    """
    _set_unless_any_is_set(_DDS_VARIABLES, str(DDS_PROFILE))
    _set_unless_any_is_set(_BLAS_VARIABLES, "1")


def of_child() -> dict[str, str]:
    """Environment for a child process, without what the ROS wheels left for this interpreter alone.

    The wheels start Python anew with LD_LIBRARY_PATH set and mark that in the environment; under another
    interpreter the mark would keep it from finding its own libraries, and the path would show it foreign ones.
    """
    environment = dict(os.environ)
    if environment.pop(_BOOTSTRAP_MARK, None):
        entries = environment.pop("LD_LIBRARY_PATH", "").split(os.pathsep)
        own = [entry for entry in entries if entry and not Path(entry).is_relative_to(sys.prefix)]
        if own:
            environment["LD_LIBRARY_PATH"] = os.pathsep.join(own)
    return environment


def _set_unless_any_is_set(names: tuple[str, ...], value: str) -> None:
    if not any(name in os.environ for name in names):
        os.environ.update(dict.fromkeys(names, value))
