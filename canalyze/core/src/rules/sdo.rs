//! Rules about SDO (CiA 301, 7.2.4): protocol, and what a description says of its objects.

use super::quantity::{Abort, Bit, Count, Crc, Hex2, Hex4, Ns, Object, Side, Size, State, Type};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// Toggle bit not alternated, or not repeated in the answer.
    Sdo001 "SDO001" "toggle-bit" Error "CiA 301 7.2.4.3.5, 7.2.4.3.6" [Sdo] {
        message "toggle位错误" "toggle bit error";
        meaning
            "分段传输中toggle位第一段为0, 以后逐段交替; 响应必须重复请求的toggle位。"
            "The toggle bit of a segmented transfer is 0 in the first segment and then alternates; a response repeats the bit of its request.";
        cause
            "协议栈实现有误, 一方重发了已被接受的段, 或者记录中丢了一帧。"
            "A fault of a stack, a segment repeated though it was accepted, or a frame missing from the capture.";
        Toggle { expected: Bit, found: Bit, by: Side }
            "{by}的toggle={found}, 应为{expected}"
            "toggle={found} from the {by}, {expected} was due";
    }

    /// A request without response, or a response without request.
    Sdo002 "SDO002" "unpaired" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "请求与响应不配对" "request and response do not pair";
        meaning
            "SDO是一问一答的: 每个请求都应有响应, 没有请求就不应有响应。"
            "SDO is question and answer: every request has a response, and there is no response without a request.";
        cause
            "节点掉线或响应太慢, 两个客户端共用一个SDO通道, 或者记录中丢了一帧。"
            "The node is gone or too slow, two clients share one SDO channel, or a frame is missing from the capture.";
        NoResponse [missing = "response"]
            "请求没有得到响应"
            "request without response";
        NoRequest [missing = "request"]
            "响应没有对应的请求"
            "response without request";
        NotAcknowledged [missing = "acknowledgement"]
            "子块没有得到确认"
            "sub-block not acknowledged";
        TimedOut [missing = "response"]
            "客户端等待超时而中止传输(0504 0000h)"
            "the client waited in vain and ended the transfer (0504 0000h)";
        Duplicate [missing = "request", duplicate = true]
            "重复的响应"
            "duplicate response";
        Flood [missing = "request", flood = true] { frames: Count }
            "大量无人请求的报文: 服务器连续发送了{frames}帧"
            "a flood of {frames} frames from the server, which nobody asked for";
        InAll [missing = "request", flood = true] { frames: Count }
            "大量无人请求的报文: 服务器共发送了{frames}帧"
            "a flood of {frames} frames from the server in all, which nobody asked for";
    }

    /// The response names another object than the request.
    Sdo003 "SDO003" "multiplexor-mismatch" Error "CiA 301 7.2.4.3.3" [Sdo] {
        message "响应的索引或子索引与请求不同" "response names another object than the request";
        meaning
            "初始化响应必须带有与请求相同的索引和子索引。"
            "An initiate response carries the index and sub-index of its request.";
        cause
            "服务器实现有误, 或者两个客户端同时使用了同一个SDO通道。"
            "A fault of the server, or two clients used the same SDO channel at once.";
        Objects { expected: Object, found: Object }
            "请求的是{expected}, 响应的是{found}"
            "asked for {expected}, answered {found}";
    }

    /// n is not 0 though e and s are not both 1.
    Sdo004 "SDO004" "invalid-unused-count" Warning "CiA 301 7.2.4.3.3" [Sdo] {
        message "未使用字节数n无效" "invalid number of unused bytes n";
        meaning
            "只有e和s都为1时n才有意义, 否则n必须为0。"
            "n has a meaning only where e and s are both 1; otherwise it shall be 0.";
        cause
            "命令字节拼错; 某些厂商手册给出的命令字节省略了e和s。"
            "A command byte put together by hand; some vendors' manuals leave out e and s.";
        Unused { unused: Count }
            "未使用字节数n无效 (n={unused})"
            "invalid number of unused bytes n (n={unused})";
    }

    /// A segment that is not the last one is not full.
    Sdo005 "SDO005" "short-segment" Info "CiA 301 7.2.4.3.5" [Sdo] {
        message "非最后段未填满" "segment not full though not the last";
        meaning
            "不是最后一段却有未使用的字节。协议栈都会接受, 但少见。"
            "A segment that is not the last one has unused bytes. Stacks accept it, but it is rare.";
        cause
            "发送方按自己的缓冲区分段。"
            "The sender cuts segments as its own buffers come.";
        Unused { unused: Count }
            "非最后段未填满 (n={unused})"
            "segment not full though not the last (n={unused})";
    }

    /// The bytes transferred are not as many as indicated.
    Sdo006 "SDO006" "size-mismatch" Error "CiA 301 7.2.4.3.3" [Sdo] {
        message "传输的字节数与声明的长度不符" "bytes transferred differ from the size indicated";
        meaning
            "初始化帧声明的长度必须等于各段数据的总字节数。"
            "The size in the initiate frame equals the sum of the segments' data bytes.";
        cause
            "最后一段的n算错, 字符串结尾的0被多算或少算, 或者记录中丢了一段。"
            "n of the last segment is wrong, a string's terminating zero was counted or not, or a segment is missing from the capture.";
        Size { indicated: Size, transferred: Size }
            "声明{indicated}, 实际传输{transferred}"
            "{indicated} indicated, {transferred} transferred";
    }

    /// A segment outside a transfer or after its last one, or a transfer without a last segment.
    Sdo007 "SDO007" "segment-outside-transfer" Error "CiA 301 7.2.4.3.5" [Sdo] {
        message "段不属于进行中的传输, 或传输没有最后段" "segment outside a transfer, or a transfer without last segment";
        meaning
            "带c=1的段结束传输, 之后不应再有段; 数据传完时必须有一段带c=1。"
            "The segment with c=1 ends a transfer: none may follow, and one must have it once all data are there.";
        cause
            "一方没有识别最后段标志, 或者最后段标志没有置位。"
            "One side overlooks the last-segment flag, or does not set it.";
        Outside [reason = "outside"]
            "该帧不属于任何进行中的传输"
            "the frame belongs to no open transfer";
        NoLast [reason = "no_last"]
            "数据已传完, 但没有任何一段带最后段标志(c=1)"
            "all data were transferred, but no segment has the last-segment flag (c=1)";
    }

    /// A new initiate request while a transfer is open.
    Sdo008 "SDO008" "restarted-transfer" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "传输未完成就开始新的传输" "new transfer while one is open";
        meaning
            "上一个传输还在进行, 客户端又发出了新的初始化请求, 且没有先中止。"
            "The client sent a new initiate request though its transfer was running, without an abort.";
        cause
            "客户端超时后直接重来, 或者两个客户端共用一个SDO通道。"
            "The client starts anew after a time-out, or two clients share one SDO channel.";
    }

    /// Reserved bits or bytes, or bytes without data, are not 0.
    Sdo009 "SDO009" "reserved-not-zero" Info "CiA 301 7.2.4.3" [Sdo] {
        message "保留位或未使用字节不为0" "reserved bits or unused bytes are not 0";
        meaning
            "保留的位和字节应为0; 大多数协议栈不检查。"
            "Reserved bits and bytes shall be 0; most stacks do not check.";
        cause
            "发送方没有清零缓冲区。"
            "The sender does not clear its buffer.";
    }

    /// An SDO frame has another length than 8 bytes.
    Sdo010 "SDO010" "frame-length" Warning "CiA 301 7.2.4.3" [Sdo] {
        message "SDO帧长度不是8字节" "SDO frame is not 8 bytes long";
        meaning
            "SDO帧总是8字节; 不少服务器会不声不响地丢弃较短的帧。"
            "SDO frames always have 8 bytes; many servers drop shorter ones without a word.";
        cause
            "发送方按实际数据长度设置了DLC。"
            "The sender sets the DLC to the length of its data.";
        Length { length: Count }
            "SDO帧长度为{length}字节, 应为8字节"
            "SDO frame of {length} bytes instead of 8";
    }

    /// SDO with a node that is Stopped or has not booted.
    Sdo011 "SDO011" "sdo-in-wrong-state" Error "CiA 301 7.3.2.2" [Sdo, ErrorControl, Nmt] {
        message "不允许SDO的状态" "SDO in a state that has none";
        meaning
            "在停止状态和启动报文之前没有SDO: 节点既不应应答, 客户端也不应询问。"
            "There is no SDO in Stopped, nor before the boot-up: a node does not answer, and a client should not ask.";
        cause
            "主站忘记先把节点切换到预操作, 或者协议栈没有按状态关闭SDO。"
            "The master has not switched the node to Pre-operational first, or the stack does not stop SDO with the state.";
        Request { state: State }
            "向处于{state}状态的节点发送SDO请求"
            "SDO request to a node that is {state}";
        Response { state: State }
            "节点处于{state}状态时应答了SDO"
            "SDO response of a node that is {state}";
        BeforeBootUp
            "复位之后, 启动报文之前应答了SDO"
            "SDO response after the reset and before the boot-up";
    }

    /// Block transfer: sequence number, acknowledgement, block size or end out of order.
    Sdo012 "SDO012" "block-sequence" Error "CiA 301 7.2.4.3.9 to 7.2.4.3.15" [Sdo] {
        message "块传输的序列号、确认或结束有误" "sequence, acknowledgement or end of a block transfer";
        meaning
            "子块内序列号从1起连续; 确认不能超过已发送的段; 块大小为1到127; 最后一段被确认后才能结束, 结束须得到确认。"
            "Sequence numbers count from 1 in each sub-block; no more is acknowledged than was sent; the block size is 1 to 127; the end comes after the last segment was acknowledged, and is confirmed.";
        cause
            "一方的块传输实现有误, 或者记录中丢了一段。"
            "A fault in one side's block transfer, or a segment missing from the capture.";
        Sequence [reason = "sequence"] { expected: Count, found: Count }
            "块序列号为{found}, 应为{expected}"
            "block sequence number {found}, {expected} was due";
        Acknowledged [reason = "acknowledged"] { ackseq: Count, sent: Count }
            "确认了第{ackseq}段, 而只发送到第{sent}段"
            "segment {ackseq} acknowledged, only {sent} sent";
        NotResent [reason = "not_resent"] { ackseq: Count }
            "只确认到第{ackseq}段, 其后的段却没有重发"
            "segments up to {ackseq} acknowledged, and those after it not sent again";
        BlockSize [reason = "block_size"] { blksize: Count }
            "块大小为{blksize}, 应为1到127"
            "block size {blksize}, must be 1 to 127";
        Outside [reason = "outside"]
            "该帧不属于任何进行中的传输"
            "the frame belongs to no open transfer";
        NoLast [reason = "no_last"]
            "数据已传完, 但没有任何一段带最后段标志(c=1)"
            "all data were transferred, but no segment has the last-segment flag (c=1)";
        EarlyEnd [reason = "early_end"]
            "最后一段尚未被确认就结束块传输"
            "the block transfer ends before its last segment was acknowledged";
        EndNotConfirmed [reason = "end_not_confirmed"]
            "块传输的结束没有得到确认"
            "the end of the block transfer was not confirmed";
    }

    /// The length of a value is not that of the object's type in the description.
    Sdo013 "SDO013" "value-length" Warning "CiA 301 7.4.7, CiA 306" [Sdo] {
        message "数据长度与对象的数据类型不符" "length of a value differs from the object's type";
        meaning
            "双方完成了传输, 但数值的字节数不是该数据类型的长度。数据类型以设备描述为准, 没有时以CiA 301规定的通信对象为准, 此时若该节点的短数值一律用4字节传输, 不算不符。"
            "Both sides completed the transfer, but the value does not have the length of the number's type: that in the description or, without one, of CiA 301 for objects that every device has; where all short values of a device are sent as four bytes, that is let pass then.";
        cause
            "EDS中的数据类型有误, 固件版本不符, 客户端用错了长度而服务器不检查, 或者服务器一律应答4字节。"
            "A wrong data type in the EDS, another firmware, a client with the wrong length and a server that does not check, or a server that answers everything with 4 bytes.";
        Written { found: Count, r#type: Type, length: Count }
            "写入{found}字节, {type}应为{length}字节"
            "written with length {found}, {type} has {length} (in bytes)";
        Read { found: Count, r#type: Type, length: Count }
            "读到{found}字节, {type}应为{length}字节"
            "read with length {found}, {type} has {length} (in bytes)";
    }

    /// An access succeeded that the description rules out.
    Sdo014 "SDO014" "access" Warning "CiA 301 7.4.3, CiA 306" [Sdo] {
        message "与设备描述的访问权限不符的访问成功了" "access against the description succeeded";
        meaning
            "设备描述不允许这样的访问, 服务器却完成了它。"
            "The description does not allow the access, but the server completed it.";
        cause
            "EDS中的AccessType有误, 固件版本不符, 或者服务器不检查访问权限。"
            "A wrong AccessType in the EDS, another firmware, or a server that does not check access.";
        Written
            "写入成功, 而设备描述中该对象只读"
            "written, but the object is read-only in the description";
        Read
            "读取成功, 而设备描述中该对象只写"
            "read, but the object is write-only in the description";
    }

    /// The same request twice without a response in between.
    Sdo015 "SDO015" "repeated-request" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "重复的请求" "repeated request";
        meaning
            "上一个请求还没有得到响应, 客户端就把它又发了一次。标准中没有重发: 超时后应先中止传输。"
            "The client sent its request again before it was answered. The standard has no repetition: after a time-out a client aborts the transfer first.";
        cause
            "客户端的超时短于服务器的响应时间, 或者第一个请求没有到达服务器。"
            "The client's time-out is shorter than the server's response time, or the first request did not reach the server.";
    }

    /// An abort names another object than the transfer that it ends.
    Sdo016 "SDO016" "abort-of-another-object" Warning "CiA 301 7.2.4.3.17" [Sdo] {
        message "中止帧的索引或子索引与传输不符" "abort names another object than the transfer";
        meaning
            "中止帧必须带有它所结束的传输的索引和子索引。"
            "An abort carries the index and sub-index of the transfer that it ends.";
        cause
            "服务器用了上一次传输的索引, 或者两个客户端同时使用了同一个SDO通道。"
            "The server took the object of the transfer before, or two clients used the same SDO channel at once.";
        Objects { expected: Object, found: Object, by: Side }
            "传输的对象是{expected}, {by}中止的是{found}"
            "the transfer is about {expected}, the {by} aborted {found}";
    }

    /// A transfer was aborted.
    Sdo017 "SDO017" "abort" Info "CiA 301 7.2.4.3.17" [Sdo] {
        message "SDO传输被中止" "SDO transfer aborted";
        meaning
            "一方用中止帧结束了传输; 中止码说明原因。"
            "One side ended the transfer with an abort; the abort code tells why.";
        cause
            "访问了不存在的对象, 读写权限或数据长度不对, 或者超时; 见中止码。"
            "An object that does not exist, access rights, a wrong length, or a time-out: see the abort code.";
        Abort { abort: Abort, by: Side }
            "{by}中止传输: {abort}"
            "aborted by the {by}: {abort}";
    }

    /// The server refused a write, and the object was not written later either.
    Sdo018 "SDO018" "write-refused" Warning "CiA 301 7.2.4.3.17" [Sdo] {
        message "写入被拒绝, 之后也没有成功" "write refused, and not made good later";
        meaning
            "服务器中止了写入, 到记录结束为止该对象也没有再被成功写入: 节点没有按主站的意图配置。"
            "The server aborted the write, and the object was not written with success before the capture's end: the node is not configured as its master wants.";
        cause
            "对象不存在或只读, 数值超出范围, 顺序不对 (例如PDO有效时修改映射); 见中止码。"
            "An object that does not exist or is read-only, a value out of range, a wrong order (such as a mapping written while the PDO is valid): see the abort code.";
        Refused { abort: Abort }
            "写入被拒绝, 之后也没有成功: {abort}"
            "write refused, and not made good later: {abort}";
    }

    /// Block transfer: the CRC does not match the data.
    Sdo019 "SDO019" "block-crc" Error "CiA 301 7.2.4.3.16" [Sdo] {
        message "块传输的CRC错误" "CRC of a block transfer is wrong";
        meaning
            "双方都声明支持CRC时, 结束帧中的CRC必须等于按CRC-16/XMODEM对数据(不含填充)计算的值。"
            "Where both sides support a CRC, the end frame carries CRC-16/XMODEM over the data without padding.";
        cause
            "使用了别的CRC算法, 把填充字节算了进去, 或者数据有误。"
            "Another CRC variant, padding counted in, or corrupt data.";
        Crc { computed: Hex4, found: Hex4, matches: Crc }
            "CRC为{found}, 按数据应为{computed}{matches}"
            "CRC {found}, the data give {computed}{matches}";
    }

    /// An answer after longer than clients usually wait, or to a request that was given up.
    Sdo020 "SDO020" "late-answer" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "迟到的应答" "late answer";
        meaning
            "服务器的应答来得太晚: 客户端一般最多等待1秒, 之后放弃请求。保存参数和擦除程序存储器不在此列。"
            "The answer came late: clients usually wait for 1 s at most and then give up. Storing parameters and erasing program memory may take longer.";
        cause
            "服务器太慢, 或者客户端超时设得太短。"
            "The server is slow, or the client's time-out too short.";
        GivenUp
            "客户端放弃请求之后应答才到"
            "the answer came after the client had given up its request";
        Booted [reason = "boot_up"]
            "应答的是服务器启动之前的请求"
            "the answer, after the server's boot-up, is to a request before it";
        Slow { delay: Ns }
            "请求发出{delay}后才应答"
            "answered {delay} after the request";
    }

    /// Initiate download with e = s = 0 whose data are meant as expedited (Roboteq's manual).
    Sdo021 "SDO021" "unmarked-expedited-download" Warning "CiA 301 7.2.4.3.3" [Sdo] {
        message "写请求的e=s=0, 数据却按加速传输发送" "write request with e=s=0 whose data are meant as expedited";
        meaning
            "按标准e=s=0表示长度未知的分段传输, 但之后没有任何段: 数据就在初始化帧里。"
            "By the standard e=s=0 starts a segmented transfer of unknown size, but no segment follows: the data are in the initiate frame.";
        cause
            "按Roboteq手册的简化说明拼出的命令字节(20h/28h/2Ch)。"
            "A command byte put together as in Roboteq's manual (20h, 28h, 2Ch).";
        Unused { unused: Count }
            "写请求的e=s=0, 数据却按加速传输发送 (n={unused})"
            "write request with e=s=0 whose data are meant as expedited (n={unused})";
    }

    /// Initiate upload response with e = s = 0 whose data are meant as expedited (Roboteq's manual).
    Sdo022 "SDO022" "unmarked-expedited-upload" Warning "CiA 301 7.2.4.3.3" [Sdo] {
        message "读响应的e=s=0, 数据却按加速传输发送" "read response with e=s=0 whose data are meant as expedited";
        meaning
            "按标准e=s=0表示长度未知的分段传输, 但客户端没有请求任何段: 数据就在初始化响应里。"
            "By the standard e=s=0 starts a segmented transfer of unknown size, but the client asks for no segment: the data are in the initiate response.";
        cause
            "设备按Roboteq手册的形式应答(40h/48h/4Ch)。"
            "A device that answers as in Roboteq's manual (40h, 48h, 4Ch).";
        Unused { unused: Count }
            "读响应的e=s=0, 数据却按加速传输发送 (n={unused})"
            "read response with e=s=0 whose data are meant as expedited (n={unused})";
    }

    /// A command specifier that the standard does not define for this side.
    Sdo023 "SDO023" "unknown-command" Error "CiA 301 7.2.4.3" [Sdo] {
        message "未定义的SDO命令字" "undefined SDO command";
        meaning
            "标准没有为这一方定义该命令字。"
            "The standard does not define this command specifier for this side.";
        cause
            "协议栈实现有误, 数据损坏, 或者该COB-ID上不是SDO。"
            "A fault of a stack, corrupt data, or something else than SDO on this COB-ID.";
        Command { command: Hex2 }
            "未定义的命令字节 {command}"
            "undefined command byte {command}";
    }

    /// Segments of a block transfer that the receiver acknowledged are not in the capture.
    Sdo024 "SDO024" "segments-not-captured" Warning "CiA 301 7.2.4.3.10, 7.2.4.3.14" [Sdo] {
        message "SDO传输的若干段未被记录" "segments of an SDO transfer are not in the capture";
        meaning
            "缺少若干段, 而双方都当作已传完: 接收方收到了, 只是记录中没有。块传输中序列号指明了位置, 这些位置以0填充。传输标为不完整。"
            "Segments are missing, and both sides took them as transferred: the receiver has got what the capture does not show. In a block transfer, where sequence numbers tell their place, it is filled with 0. The transfer counts as incomplete.";
        cause
            "记录设备丢帧, 或者报文是从较长的记录中摘录的。"
            "The recorder lost frames, or the capture is an excerpt.";
        Missing [reason = "missing"] { missing: Count }
            "记录中缺少{missing}段"
            "{missing|segment is|segments are} not in the capture";
        Elsewhere [reason = "elsewhere"]
            "记录中缺少若干帧: 双方已在进行另一次传输"
            "frames are not in the capture: both sides are in another transfer";
    }

    /// Block transfer: the receiver acknowledged a part of a sub-block, and asks for the others again.
    Sdo025 "SDO025" "asked-again" Info "CiA 301 7.2.4.3.10, 7.2.4.3.14" [Sdo] {
        message "块传输的若干段须重发" "segments of a block transfer are asked for again";
        meaning
            "接收方只确认了子块的一部分: 其后的段没有收到或被丢弃, 发送方须从1起重新编号再发一次。这是协议允许的。"
            "The receiver acknowledged a part of the sub-block only: it has not got the others, or has dropped them, and the sender sends them once more, numbered from 1. The protocol provides for it.";
        cause
            "总线或接收缓冲区丢帧, 接收方来不及处理。"
            "Frames lost on the bus or in the receiver's buffer, or a receiver that is too slow.";
        Again { first: Count, last: Count }
            "第{first}至{last}段须重发"
            "segments {first} to {last} are asked for again";
        One { segment: Count }
            "第{segment}段须重发"
            "segment {segment} is asked for again";
    }

    /// The traffic on these identifiers does not look like SDO.
    Sdo030 "SDO030" "not-sdo" Info "-" [Sdo] {
        message "该通道的报文不像SDO" "traffic does not look like SDO";
        meaning
            "这些COB-ID上没有出现过一对有效的请求和响应, 因此不对它们作SDO判断。"
            "No valid pair of request and response was seen on these COB-IDs, so they are not judged as SDO.";
        cause
            "网络不是CANopen, 只记录到一个方向, 或者COB-ID被别的协议使用。"
            "The network is not CANopen, only one direction was captured, or another protocol uses the identifiers.";
        Frames { frames: Count }
            "该通道的报文不像SDO ({frames}帧)"
            "traffic does not look like SDO ({frames|frame|frames})";
        Flood { frames: Count, duration: Ns }
            "没有任何请求, {duration}内却有{frames}帧来自服务器: 大量无人请求的报文"
            "a flood of {frames} frames from the server within {duration}, which nobody asked for";
    }

    /// Requests of which none was answered in the capture.
    Sdo031 "SDO031" "no-server" Warning "-" [Sdo] {
        message "请求从未得到应答" "requests never answered";
        meaning
            "记录中该节点没有任何SDO响应。"
            "The capture has no SDO response of this node.";
        cause
            "节点不存在或未上电(主站扫描), 或者只记录到一个方向。"
            "The node does not exist or has no power (a master scans), or only one direction was captured.";
        Frames { frames: Count }
            "请求从未得到应答 ({frames}帧)"
            "requests never answered ({frames|frame|frames})";
    }

    /// Of SDO channels only one direction was recorded.
    Sdo032 "SDO032" "one-direction" Info "-" [Sdo] {
        message "SDO只记录到一个方向" "one direction of SDO was not recorded";
        meaning
            "记录中只有请求或只有应答, 而通信显然在正常进行: 缺少的是记录, 不是应答。写入的值只是请求值, 没有得到确认, 也不据此判断任何节点。"
            "The capture has only requests, or only answers, though the transfers clearly went on: the recording lacks the others, not the bus. Values of writes are those requested and not confirmed, and no node is judged by them.";
        cause
            "记录程序设置了接收过滤器, 或只记录自己发送的报文, 或者是从记录中摘取的片段。"
            "A filter of the recording program, a program that logs only what it sends itself, or an excerpt.";
        Answers { requests: Count }
            "没有记录到应答方向: {requests}帧请求没有应答, 而主站照常继续"
            "the answers are not in the capture: {requests} frames of the client have none, and it goes on as if answered";
        AnswersOfAll { requests: Count, servers: Count }
            "没有记录到{servers}个节点的应答方向: {requests}帧请求没有应答, 而主站照常继续"
            "the answers of {servers} nodes are not in the capture: {requests} frames of the client have none, and it goes on as if answered";
        Requests { answers: Count }
            "没有记录到请求方向: 只有服务器的{answers}帧应答"
            "the requests are not in the capture, only {answers} answers of the server";
        RequestsOfAll { answers: Count, servers: Count }
            "没有记录到请求方向: 只有{servers}个节点的{answers}帧应答"
            "the requests are not in the capture, only {answers} answers of {servers} nodes";
    }
}
