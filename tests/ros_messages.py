"""Definitions of the ROS messages that hold CAN frames, as their packages publish them.

Why it exists: recordings are made of them in several ways. What it must not do: know how a recording is written.
"""

_RULE = "=" * 80
_HEADER = f"""{_RULE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_RULE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
FRAME = f"""# A frame
std_msgs/Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
{_HEADER}"""
FD_FRAME = f"""std_msgs/Header header
uint32 id
bool is_extended
bool is_error
uint8 len
uint8[<=64] data
{_HEADER}"""
DATASPEED = f"""std_msgs/Header header
uint32 id
bool extended
bool fdf
bool brs
bool esi
bool rtr
uint8[<=64] data
{_HEADER}"""
DATASPEED_16 = DATASPEED.replace("uint8[<=64] data", "uint8 size\nuint8[16] data")
STAMPED = f"""std_msgs/Header header
CanMessage msg
{_RULE}
MSG: dataspeed_can_msgs/CanMessage
uint8[8] data
uint32 id
bool extended
uint8 dlc
{_HEADER}"""
FRAME_ROS1 = f"""Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
{_RULE}
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
"""
