"""Definitions of the ROS messages that hold CAN frames, as their packages publish them.

Why it exists: recordings are made of them in several ways. What it must not do: know how a recording is written.
"""

from captures import DATA

FRAME, FD_FRAME, DATASPEED, DATASPEED_16, STAMPED, FRAME_ROS1 = (
    (DATA / "ros" / f"{name}.msg").read_text()
    for name in ("frame", "fd_frame", "dataspeed", "dataspeed_16", "stamped", "frame_ros1")
)
