//! Rules about SDO (CiA 301, 7.2.4): the protocol, and the objects of a description.

use crate::bytes::ns::Ns;

use super::quantity::{Abort, Bit, Count, Crc, Hex2, Hex4, Object, Side, Size, State, Type};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 分段传输中toggle位第一段为0, 以后逐段交替; 响应必须重复请求的toggle位。
    /// The toggle bit of a segmented transfer is 0 in the first segment and then alternates; a response repeats the bit of its request.
    ///
    /// 协议栈实现有误, 一方重发了已被接受的段, 或者记录中丢了一帧。
    /// A stack bug, a segment repeated although it was accepted, or a frame missing from the capture.
    Sdo001 "SDO001" "toggle-bit" Error "CiA 301 7.2.4.3.5, 7.2.4.3.6" [Sdo] {
        message "toggle位错误" "toggle bit error";
        Toggle { expected: Bit, found: Bit, by: Side }
            "{by}的toggle={found}, 应为{expected}" "{by} sent toggle={found}, expected {expected}";
        Counter [counter = true] { expected: Count, found: Count, by: Side }
            "{by}的段计数器为{found}, 应为{expected}" "{by} sent segment counter {found}, expected {expected}";
    }

    /// SDO采用一问一答方式: 每个请求都应有响应, 没有请求就不应有响应。
    /// SDO is request and response: every request has a response, and there is no response without a request.
    ///
    /// 节点掉线或响应太慢, 两个客户端共用一个SDO通道, 或者记录中丢了一帧。
    /// The node is offline or too slow, two clients share one SDO channel, or a frame is missing from the capture.
    Sdo002 "SDO002" "unpaired" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "请求与响应不配对" "request and response do not pair";
        NoResponse [missing = "response"] "请求未得到响应" "request without response";
        NoRequest [missing = "request"] "收到没有请求的响应" "response without request";
        NotAcknowledged [missing = "acknowledgement"] "子块未得到确认" "sub-block not acknowledged";
        TimedOut [missing = "response"]
            "主站等待超时, 中止了传输(05040000h)" "the client timed out and aborted the transfer (05040000h)";
        Duplicate [missing = "request", duplicate = true] "重复的响应" "duplicate response";
        Flood [missing = "request", flood = true] { frames: Count }
            "从站连续发送{frames}帧没有请求的报文" "the server sent {frames} frames in a row without a request";
        InAll [missing = "request", flood = true] { frames: Count }
            "从站共发送{frames}帧没有请求的报文" "the server sent {frames} frames in total without a request";
    }

    /// 初始化响应必须带有与请求相同的索引和子索引。
    /// An initiate response carries the index and sub-index of its request.
    ///
    /// 服务器实现有误, 或者两个客户端同时使用了同一个SDO通道。
    /// A server bug, or two clients using the same SDO channel at the same time.
    Sdo003 "SDO003" "multiplexor-mismatch" Error "CiA 301 7.2.4.3.3" [Sdo] {
        message "响应的索引或子索引与请求不同" "response names another object than the request";
        Objects { expected: Object, found: Object }
            "请求{expected}, 响应的却是{found}" "requested {expected}, response names {found}";
    }

    /// 只有e和s都为1时n才有意义, 否则n必须为0。
    /// n has a meaning only where e and s are both 1; otherwise it shall be 0.
    ///
    /// 命令字节拼错; 某些制造商手册给出的命令字节省略了e和s。
    /// A hand-made command byte; some vendors' manuals leave out e and s.
    Sdo004 "SDO004" "invalid-unused-count" Warning "CiA 301 7.2.4.3.3" [Sdo] {
        message "未使用字节数n无效" "invalid number of unused bytes n";
        Unused { unused: Count } "未使用字节数n无效 (n={unused})" "invalid number of unused bytes n (n={unused})";
    }

    /// 不是最后一段却有未使用的字节。协议栈都会接受, 但少见。
    /// A segment that is not the last one has unused bytes. Stacks accept it, but it is rare.
    ///
    /// 发送方按自己的缓冲区分段。
    /// The sender fills segments by its own buffer size.
    Sdo005 "SDO005" "short-segment" Info "CiA 301 7.2.4.3.5" [Sdo] {
        message "非最后段未填满" "segment not full though not the last";
        Unused { unused: Count } "非最后段未填满 (n={unused})" "segment not full though not the last (n={unused})";
    }

    /// 初始化帧声明的长度必须等于各段数据的总字节数。
    /// The size in the initiate frame equals the sum of the segments' data bytes.
    ///
    /// 最后一段的n算错, 字符串结尾的0被多算或少算, 或者记录中丢了一段。
    /// n of the last segment is wrong, a string's terminating zero was counted or not, or a segment is missing from the capture.
    Sdo006 "SDO006" "size-mismatch" Error "CiA 301 7.2.4.3.3" [Sdo] {
        message "传输的字节数与声明的长度不符" "bytes transferred differ from the size indicated";
        Size { indicated: Size, transferred: Size }
            "声明{indicated}, 实际传输{transferred}" "{indicated} indicated, {transferred} transferred";
    }

    /// 带c=1的段结束传输, 之后不应再有段; 数据传完时必须有一段带c=1。
    /// The segment with c=1 ends a transfer: none may follow, and one must have it once all data are there.
    ///
    /// 一方没有识别最后段标志, 或者最后段标志没有置位。
    /// One side overlooks the last-segment flag, or does not set it.
    Sdo007 "SDO007" "segment-outside-transfer" Error "CiA 301 7.2.4.3.5" [Sdo] {
        message "段不属于进行中的传输, 或传输没有最后段" "segment outside a transfer, or a transfer without last segment";
        Outside [reason = "outside"] "该帧不属于任何进行中的传输" "the frame belongs to no open transfer";
        NoLast [reason = "no_last"]
            "数据已传完, 但没有任何一段带最后段标志(c=1)" "all data were transferred, but no segment has the last-segment flag (c=1)";
    }

    /// 上一个传输仍在进行, 客户端没有先中止就发出了新的初始化请求。
    /// The client sent a new initiate request while its transfer was still running, without aborting it first.
    ///
    /// 客户端超时后直接重试, 或者两个客户端共用一个SDO通道。
    /// The client retries after a timeout, or two clients share one SDO channel.
    Sdo008 "SDO008" "restarted-transfer" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "传输未完成就开始新的传输" "new transfer while one is open";
    }

    /// 保留的位和字节应为0; 大多数协议栈不检查。
    /// Reserved bits and bytes shall be 0; most stacks do not check.
    ///
    /// 发送方没有清零缓冲区。
    /// The sender does not clear its buffer.
    Sdo009 "SDO009" "reserved-not-zero" Info "CiA 301 7.2.4.3" [Sdo] {
        message "保留位或未使用字节不为0" "reserved bits or unused bytes are not 0";
    }

    /// SDO帧固定为8字节; 不少服务器会直接丢弃较短的帧而不报错。
    /// SDO frames are always 8 bytes long; many servers silently drop shorter ones.
    ///
    /// 发送方按实际数据长度设置了DLC。
    /// The sender sets the DLC to the length of its data.
    Sdo010 "SDO010" "frame-length" Warning "CiA 301 7.2.4.3" [Sdo] {
        message "SDO帧长度不是8字节" "SDO frame is not 8 bytes long";
        Request { length: Count } "SDO请求长度为{length}字节, 应为8字节" "SDO request is {length|byte|bytes} long, expected 8";
        Response { length: Count } "SDO响应长度为{length}字节, 应为8字节" "SDO response is {length|byte|bytes} long, expected 8";
    }

    /// 停止状态和启动报文之前不允许SDO: 节点不应响应, 客户端也不应请求。
    /// SDO is not allowed in Stopped, nor before the boot-up: a node does not respond, and a client should not send requests.
    ///
    /// 主站没有先把节点切换到预操作状态, 或者协议栈没有按状态关闭SDO。
    /// The master did not switch the node to Pre-operational first, or the stack does not disable SDO with the state.
    Sdo011 "SDO011" "sdo-in-wrong-state" Error "CiA 301 7.3.2.2" [Sdo, ErrorControl, Nmt] {
        message "在不允许SDO的状态下收发SDO" "SDO in a state that does not allow it";
        Request { state: State } "向处于{state}的节点发送SDO请求" "SDO request to a node that is {state}";
        Response { state: State } "节点处于{state}时响应了SDO" "SDO response of a node that is {state}";
        BeforeBootUp "复位之后, 启动报文之前响应了SDO" "SDO response after the reset and before the boot-up";
    }

    /// 子块内序列号从1起连续; 确认不能超过已发送的段; 块大小为1到127; 最后一段被确认后才能结束, 结束须得到确认。
    /// Sequence numbers count from 1 in each sub-block; no more is acknowledged than was sent; the block size is 1 to 127; the end comes after the last segment was acknowledged, and is confirmed.
    ///
    /// 一方的块传输实现有误, 或者记录中丢了一段。
    /// A bug in one side's block transfer, or a segment missing from the capture.
    Sdo012 "SDO012" "block-sequence" Error "CiA 301 7.2.4.3.9 to 7.2.4.3.15" [Sdo] {
        message "块传输过程错误(序列号、确认或结束)" "block transfer error (sequence, acknowledgement or end)";
        Sequence [reason = "sequence"] { expected: Count, found: Count }
            "块序列号为{found}, 应为{expected}" "block sequence number {found}, expected {expected}";
        Acknowledged [reason = "acknowledged"] { ackseq: Count, sent: Count }
            "确认到第{ackseq}段, 实际只发送到第{sent}段" "segment {ackseq} acknowledged, but only {sent} sent";
        NotResent [reason = "not_resent"] { ackseq: Count }
            "只确认到第{ackseq}段, 其后的段却没有重发" "segments up to {ackseq} acknowledged, but the later ones were not resent";
        BlockSize [reason = "block_size"] { blksize: Count }
            "块大小为{blksize}, 应为1到127" "block size {blksize}, expected 1 to 127";
        Outside [reason = "outside"] "该帧不属于任何进行中的传输" "the frame belongs to no open transfer";
        NoLast [reason = "no_last"]
            "数据已传完, 但没有任何一段带最后段标志(c=1)" "all data were transferred, but no segment has the last-segment flag (c=1)";
        EarlyEnd [reason = "early_end"]
            "最后一段尚未被确认就结束块传输" "the block transfer ends before its last segment was acknowledged";
        EndNotConfirmed [reason = "end_not_confirmed"] "块传输的结束未得到确认" "the end of the block transfer was not confirmed";
    }

    /// 双方完成了传输, 但数值的字节数不是该数据类型的长度。数据类型以设备描述为准, 没有时以CiA 301规定的通信对象为准, 此时若该节点的短数值一律用4字节传输, 则不报告。
    /// Both sides completed the transfer, but the value does not have the length of its data type: the type in the description or, without one, that of CiA 301 for communication objects. Without a description, devices that send all short values as four bytes are not reported.
    ///
    /// EDS中的数据类型有误, 固件版本不符, 客户端用错了长度而服务器不检查, 或者服务器的响应一律为4字节。
    /// A wrong data type in the EDS, another firmware, a client with the wrong length and a server that does not check, or a server that always responds with 4 bytes.
    Sdo013 "SDO013" "value-length" Warning "CiA 301 7.4.7, CiA 306" [Sdo] {
        message "数据长度与对象的数据类型不符" "length of a value differs from the object's type";
        Written { found: Count, r#type: Type, length: Count }
            "写入{found}字节, {type}应为{length}字节" "{found|byte|bytes} written, {type} has {length}";
        Read { found: Count, r#type: Type, length: Count }
            "读到{found}字节, {type}应为{length}字节" "{found|byte|bytes} read, {type} has {length}";
    }

    /// 设备描述不允许这样的访问, 服务器却执行了。
    /// The description does not allow the access, but the server completed it.
    ///
    /// EDS中的AccessType有误, 固件版本不符, 或者服务器不检查访问权限。
    /// A wrong AccessType in the EDS, another firmware, or a server that does not check access.
    Sdo014 "SDO014" "access" Warning "CiA 301 7.4.3, CiA 306" [Sdo] {
        message "访问成功, 但违反设备描述中的访问权限" "access succeeded against the access right in the description";
        Written "写入成功, 而设备描述中该对象只读" "written, but the object is read-only in the description";
        Read "读取成功, 而设备描述中该对象只写" "read, but the object is write-only in the description";
    }

    /// 上一个请求尚未得到响应, 客户端就重发了它。标准没有规定重发: 超时后应先中止传输。
    /// The client sent its request again before the response. The standard has no repetition: after a timeout the client aborts the transfer first.
    ///
    /// 客户端的超时短于服务器的响应时间, 或者第一个请求没有到达服务器。
    /// The client's timeout is shorter than the server's response time, or the first request did not reach the server.
    Sdo015 "SDO015" "repeated-request" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "未等到响应就重发请求" "request repeated before its response";
    }

    /// 中止帧必须带有它所结束的传输的索引和子索引。
    /// An abort carries the index and sub-index of the transfer that it ends.
    ///
    /// 服务器使用了上一次传输的索引, 或者两个客户端同时使用了同一个SDO通道。
    /// The server used the object of the previous transfer, or two clients used the same SDO channel at the same time.
    Sdo016 "SDO016" "abort-of-another-object" Warning "CiA 301 7.2.4.3.17" [Sdo] {
        message "中止帧的索引或子索引与传输不符" "abort names another object than the transfer";
        Objects { expected: Object, found: Object, by: Side }
            "传输的对象为{expected}, {by}中止的却是{found}" "the transfer is about {expected}, the {by} aborted {found}";
    }

    /// 一方用中止帧结束了传输; 中止码说明原因。
    /// One side ended the transfer with an abort; the abort code gives the reason.
    ///
    /// 访问了不存在的对象, 读写权限或数据长度不对, 或者超时; 见中止码。
    /// An object that does not exist, access rights, a wrong length, or a timeout: see the abort code.
    Sdo017 "SDO017" "abort" Info "CiA 301 7.2.4.3.17" [Sdo] {
        message "SDO传输被中止" "SDO transfer aborted";
        Abort { abort: Abort, by: Side } "{by}中止传输: {abort}" "aborted by the {by}: {abort}";
    }

    /// 服务器中止了写入, 到记录结束为止该对象也没有再被成功写入: 节点没有按主站的意图配置。
    /// The server aborted the write, and the object was not written successfully until the end of the capture: the node is not configured as the master intends.
    ///
    /// 对象不存在或只读, 数值超出范围, 顺序不对 (例如PDO有效时修改映射); 见中止码。
    /// An object that does not exist or is read-only, a value out of range, a wrong order (such as a mapping written while the PDO is valid): see the abort code.
    Sdo018 "SDO018" "write-refused" Warning "CiA 301 7.2.4.3.17" [Sdo] {
        message "写入被拒绝, 之后也未成功" "write refused, and not repeated successfully";
        Refused { abort: Abort } "写入被拒绝, 之后也未成功: {abort}" "write refused, and not repeated successfully: {abort}";
    }

    /// 双方都声明支持CRC时, 结束帧中的CRC必须等于按CRC-16/XMODEM对数据(不含填充)计算的值。
    /// Where both sides support a CRC, the end frame carries CRC-16/XMODEM over the data without padding.
    ///
    /// 使用了别的CRC算法, 把填充字节算了进去, 或者数据有误。
    /// Another CRC variant, padding counted in, or corrupt data.
    Sdo019 "SDO019" "block-crc" Error "CiA 301 7.2.4.3.16" [Sdo] {
        message "块传输的CRC错误" "wrong CRC in a block transfer";
        Crc { computed: Hex4, found: Hex4, matches: Crc }
            "CRC为{found}, 按数据计算应为{computed}{matches}" "CRC is {found}, computed {computed}{matches}";
    }

    /// 服务器的响应过晚: 客户端一般最多等待1秒, 之后放弃请求。存储参数和擦除程序存储器允许更长。
    /// The response came late: clients usually wait 1 s at most and then give up. Storing parameters and erasing program memory may take longer.
    ///
    /// 服务器太慢, 或者客户端超时设得太短。
    /// The server is slow, or the client's timeout is too short.
    Sdo020 "SDO020" "late-answer" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "响应超时后才到达" "response after the timeout";
        GivenUp "主站放弃请求之后响应才到达" "the response came after the client had given up the request";
        Booted [reason = "boot_up"]
            "响应的是从站重新启动之前的请求" "the response comes after the server's boot-up, to a request sent before it";
        Slow { delay: Ns } "请求发出{delay}后才响应" "response {delay} after the request";
    }

    /// 按标准e=s=0表示长度未知的分段传输, 但之后没有任何段: 数据就在初始化帧里。
    /// By the standard e=s=0 starts a segmented transfer of unknown size, but no segment follows: the data are in the initiate frame.
    ///
    /// 按Roboteq手册的简化说明拼出的命令字节(20h/28h/2Ch)。
    /// A command byte made after Roboteq's manual (20h, 28h, 2Ch).
    Sdo021 "SDO021" "unmarked-expedited-download" Warning "CiA 301 7.2.4.3.3" [Sdo] {
        message "写请求的e=s=0, 数据却按加速传输发送" "write request with e=s=0 but expedited data";
        Unused { unused: Count }
            "写请求的e=s=0, 数据却按加速传输发送 (n={unused})" "write request with e=s=0 but expedited data (n={unused})";
    }

    /// 按标准e=s=0表示长度未知的分段传输, 但客户端没有请求任何段: 数据就在初始化响应里。
    /// By the standard e=s=0 starts a segmented transfer of unknown size, but the client asks for no segment: the data are in the initiate response.
    ///
    /// 设备按Roboteq手册的形式响应(40h/48h/4Ch)。
    /// A device that responds as in Roboteq's manual (40h, 48h, 4Ch).
    Sdo022 "SDO022" "unmarked-expedited-upload" Warning "CiA 301 7.2.4.3.3" [Sdo] {
        message "读响应的e=s=0, 数据却按加速传输发送" "read response with e=s=0 but expedited data";
        Unused { unused: Count }
            "读响应的e=s=0, 数据却按加速传输发送 (n={unused})" "read response with e=s=0 but expedited data (n={unused})";
    }

    /// 标准没有为这一方定义该命令字。
    /// The standard does not define this command specifier for this side.
    ///
    /// 协议栈实现有误, 数据损坏, 或者该COB-ID上不是SDO。
    /// A stack bug, corrupt data, or another protocol on this COB-ID.
    Sdo023 "SDO023" "unknown-command" Error "CiA 301 7.2.4.3" [Sdo] {
        message "未定义的SDO命令字" "undefined SDO command";
        Command { command: Hex2 } "未定义的命令字节 {command}" "undefined command byte {command}";
    }

    /// 缺少若干帧, 而双方的通信照常进行: 对方已收到, 只是没有录到。块传输中由序列号可知其位置, 这些位置以0填充。传输标为不完整。
    /// Frames are missing, but both sides went on as if transferred: the receiver got what was not captured. In a block transfer, where the sequence numbers give their place, it is filled with 0. The transfer is marked incomplete.
    ///
    /// 记录设备丢帧, 或者报文是从较长的记录中摘录的。
    /// The recorder lost frames, or the capture is an excerpt.
    Sdo024 "SDO024" "segments-not-captured" Warning "CiA 301 7.2.4.3.10, 7.2.4.3.14" [Sdo] {
        message "SDO传输的若干帧未录到" "frames of an SDO transfer are not in the capture";
        Response [reason = "response"]
            "记录中缺少响应: 客户端随即继续" "the response is not in the capture: the client goes on immediately";
        Acknowledgement [reason = "acknowledgement"]
            "记录中缺少子块的确认: 发送方随即继续"
            "the acknowledgement of the sub-block is not in the capture: its sender goes on immediately";
        Data [reason = "data"] "记录中缺少传输的数据段" "the segments with the data are not in the capture";
        Missing [reason = "missing"] { missing: Count }
            "记录中缺少{missing}段" "{missing|segment is|segments are} not in the capture";
        Elsewhere [reason = "elsewhere"]
            "记录中缺少若干帧: 双方已开始另一次传输" "frames are missing from the capture: both sides are already in another transfer";
    }

    /// 接收方只确认了子块的一部分: 其后的段没有收到或被丢弃, 发送方须从1起重新编号再发一次。这是协议允许的。
    /// The receiver acknowledged only part of the sub-block: the others were not received or dropped, and the sender resends them, numbered from 1. The protocol allows this.
    ///
    /// 总线或接收缓冲区丢帧, 接收方来不及处理。
    /// Frames lost on the bus or in the receiver's buffer, or a receiver that is too slow.
    Sdo025 "SDO025" "asked-again" Info "CiA 301 7.2.4.3.10, 7.2.4.3.14" [Sdo] {
        message "块传输的若干段须重发" "segments of a block transfer requested again";
        Again { first: Count, last: Count } "第{first}至{last}段须重发" "segments {first} to {last} requested again";
        One { segment: Count } "第{segment}段须重发" "segment {segment} requested again";
    }

    /// 服务器已响应, 轮到客户端继续传输或中止, 但直到记录结束它都没有再发。
    /// The server has answered, and the client owes the next request or an abort, but sends neither until the capture ends.
    ///
    /// 客户端程序退出或崩溃, 或者放弃传输时没有发送中止; 服务器会一直停在这个传输里。
    /// The client's program has ended or crashed, or gives up without an abort; the server stays in the transfer.
    Sdo026 "SDO026" "abandoned-transfer" Warning "CiA 301 7.2.4.1" [Sdo] {
        message "客户端放弃传输而没有中止" "the client leaves its transfer without an abort";
        Left { idle: Ns } "客户端{idle}没有继续传输, 也没有中止" "the client has neither gone on for {idle} nor aborted";
    }

    /// 这些COB-ID上没有出现过一对有效的请求和响应, 因此不对它们作SDO判断。
    /// No valid pair of request and response was seen on these COB-IDs, so they are not judged as SDO.
    ///
    /// 网络不是CANopen, 只记录到一个方向, 或者COB-ID被别的协议使用。
    /// The network is not CANopen, only one direction was captured, or another protocol uses the identifiers.
    Sdo030 "SDO030" "not-sdo" Info "-" [Sdo] {
        message "该通道的报文不像SDO" "traffic does not look like SDO";
        Frames { frames: Count } "该通道的报文不像SDO ({frames}帧)" "traffic does not look like SDO ({frames|frame|frames})";
        Flood { frames: Count, duration: Ns } "没有任何请求, 从站却在{duration}内发送了{frames}帧"
            "the server sent {frames} frames within {duration} without any request";
    }

    /// 记录中该节点没有任何SDO响应。
    /// The capture has no SDO response of this node.
    ///
    /// 节点不存在或未上电(主站扫描), 或者只记录到一个方向。
    /// The node does not exist or has no power (a master scans), or only one direction was captured.
    Sdo031 "SDO031" "no-server" Warning "-" [Sdo] {
        message "请求从未得到响应" "requests never answered";
        Frames { frames: Count }
            "该节点尚未响应任何SDO请求(共{frames}帧)" "the node has not answered any SDO request ({frames|frame|frames})";
    }

    /// 记录中只有请求或只有响应, 而通信显然在正常进行: 另一方向没有录到。写入的值只是请求值, 未经确认, 也不据此判断任何节点。
    /// The capture has only requests or only responses, although the transfers clearly went on: the other direction was not captured. Written values are those requested, not confirmed, and no node is judged by them.
    ///
    /// 记录程序设置了接收过滤器, 或只记录自己发送的报文, 或者是从记录中摘取的片段。
    /// A filter of the recording program, a program that logs only what it sends itself, or an excerpt.
    Sdo032 "SDO032" "one-direction" Info "-" [Sdo] {
        message "SDO只记录到一个方向" "only one direction of SDO captured";
        Answers { requests: Count } "未录到响应方向: 主站的{requests}帧请求没有响应, 却照常继续"
            "responses not captured: {requests} requests without response, but the client continues normally";
        AnswersOfAll { requests: Count, servers: Count }
            "未录到{servers}个节点的响应方向: 主站的{requests}帧请求没有响应, 却照常继续"
            "responses of {servers} nodes not captured: {requests} requests without response, but the client continues normally";
        Requests { answers: Count }
            "未录到请求方向: 只有从站的{answers}帧响应" "requests not captured, only {answers} responses from the server";
        RequestsOfAll { answers: Count, servers: Count } "未录到请求方向: 只有{servers}个节点的{answers}帧响应"
            "requests not captured, only {answers} responses from {servers} nodes";
    }
}
