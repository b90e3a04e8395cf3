"""`python -m risorius_ros`, `ros2 run risorius_ros face_engine`: the node as a process."""

from __future__ import annotations

import signal
import sys

from risorius_ros import environment


def main() -> None:
    """Run the node; exits 0 when stopped, 2 with one line when it cannot start."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # no traceback from the imports; the node has handlers of its own
    environment.prepare()  # before these imports bring numpy and rclpy
    from risorius import Error
    from risorius_ros import face_engine

    try:
        face_engine.run(sys.argv)
    except Error as error:
        print(f"risorius: {error}", file=sys.stderr)
        sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
