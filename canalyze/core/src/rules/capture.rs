//! Rules about the capture itself: what of it cannot be read or is missing.

use super::quantity::{Count, JsonOnly, Ns};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// Lines that should hold a frame and cannot be read.
    Cap001 "CAP001" "unreadable-lines" Warning "-" [] {
        message "有无法读取的行或记录" "lines or records that cannot be read";
        meaning
            "它们既不是所读格式的帧, 也不是注释; 其余内容照常解析。"
            "They are neither frames of the format that is read nor comments; all others are decoded all the same.";
        cause
            "文件被截断或编辑过, 混入了其他程序的输出, 或者是尚不支持的格式。"
            "The file was cut or edited, holds another program's output, or is of a format not supported yet.";
        Lines { lines: Count }
            "{lines}行无法读取"
            "{lines|line|lines} cannot be read";
        OfFurtherBuses { lines: Count, further_buses: Count }
            "{lines}行无法读取, 其中{further_buses}行属于超出数量上限的总线"
            "{lines|line|lines} cannot be read, {further_buses} of them since there are too many buses";
    }

    /// The capturing program says that it lost frames.
    Cap002 "CAP002" "dropped-frames" Warning "-" [] {
        message "记录程序丢帧" "frames lost by the capturing program";
        meaning
            "记录程序自己声明丢失了帧。丢帧处的toggle位、序列号和应答不再判断, 进行中的传输记为不完整。"
            "The capturing program says itself that it lost frames. Across the gap no toggle bit, sequence number or answer is judged, and open transfers are incomplete.";
        cause
            "接收缓冲区太小、主机太忙或存储太慢; candump可用 -r、dumpcap可用 -B 加大缓冲区, 其他记录程序见其缓冲设置。"
            "The receive buffer is too small, the host too busy or its disk too slow; candump takes a larger buffer with -r, dumpcap with -B, other programs in their settings.";
        Dropped { frames: Count, total: Count }
            "丢失{frames}帧 (累计{total}帧)"
            "{frames|frame|frames} lost ({total} in total)";
    }

    /// Stamps of a pipe go backwards.
    Cap003 "CAP003" "stamps-backward" Warning "-" [] {
        message "时间戳倒退" "time stamps go backwards";
        meaning
            "管道中的时间戳按从零开始解释, 但出现了倒退: 它们很可能是与前一帧的差值。"
            "The stamps of a pipe were taken as counted from zero, but one goes backwards: they are probably differences to the frame before.";
        cause
            "candump使用了 -t d; 请加上 --stamps delta。"
            "candump ran with -t d; add --stamps delta.";
    }

    /// A part of the file is damaged and was passed over.
    Cap004 "CAP004" "damaged-capture" Warning "-" [] {
        message "文件有一部分损坏" "a part of the file is damaged";
        meaning
            "损坏处前后能读的内容都已读取。跨越缺口不判断toggle位、序号和应答, 未完成的传输记为不完整。校验和在其所覆盖的数据之后, 不符时这些数据都可能有误。"
            "What can be read before and after it is read. Across the gap no toggle bit, sequence number or answer is judged, and open transfers are incomplete. A check sum that comes behind what it covers makes all of that doubtful where it fails.";
        cause
            "记录设备断电、存储介质出错, 或文件在传送中被改动; 请重新拷贝并比较校验和。"
            "The recording machine lost power, the medium has errors, or the file was changed on its way; copy it again and compare check sums.";
        Checksum { offset: JsonOnly<Option<Count>>, bytes: Option<Count> }
            "校验和不符; 跳过{bytes}字节"
            "the check sum does not match; {bytes} bytes were passed over";
        Structure { offset: JsonOnly<Option<Count>>, bytes: Option<Count> }
            "长度或类型无效; 跳过{bytes}字节"
            "a length or type that cannot be; {bytes} bytes were passed over";
        Compression { offset: JsonOnly<Option<Count>>, bytes: Option<Count> }
            "压缩数据损坏; 跳过{bytes}字节"
            "compressed data are damaged; {bytes} bytes were passed over";
        ChecksumUncounted { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "校验和不符; 跳过的字节数不明"
            "the check sum does not match; how many bytes were passed over is not known";
        StructureUncounted { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "长度或类型无效; 跳过的字节数不明"
            "a length or type that cannot be; how many bytes were passed over is not known";
        CompressionUncounted { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "压缩数据损坏; 跳过的字节数不明"
            "compressed data are damaged; how many bytes were passed over is not known";
        Rest { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "文件的其余部分无法读取"
            "the rest of the file cannot be read";
        Undefined { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "部分topic的定义已丢失或无法使用, 其消息已跳过"
            "messages of topics whose definition is lost or cannot be used were passed over";
        UndefinedWithFrames { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Count }
            "部分topic的定义已丢失或无法使用, 其{frames}条消息已跳过"
            "{frames|message|messages} of topics whose definition is lost or cannot be used were passed over";
        Doubtful { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: JsonOnly<Option<Count>> }
            "压缩数据损坏: 由此起解出的内容都可能有误; 其后跳过{bytes}字节"
            "compressed data are damaged: all that was unpacked from here on may be wrong; {bytes} bytes behind it were passed over";
        DoubtfulWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "压缩数据损坏: 由此起解出的{frames}帧都可能有误; 其后跳过{bytes}字节"
            "compressed data are damaged: all that was unpacked from here on, {frames} frames, may be wrong; {bytes} bytes behind it were passed over";
        Definition { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Option<Count> }
            "此处损坏, 其中topic和类型的定义只能照用; 按其读取的{frames}帧可能有误"
            "what is damaged here defines topics and types, and had to be used: {frames} frames that were read by it may be wrong";
        Missing { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Option<Count> }
            "按文件自身的统计, 还缺{frames}条消息, 未能找到"
            "by the file's own statistics {frames} more messages are missing: they were not found";
        Unlocated { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Option<Count> }
            "全部数据的校验和不符, 但看不出损坏在何处; 已读取的{frames}帧可能有误"
            "the check sum over all of the data does not match, and nothing shows where: {frames} frames that were read may be wrong";
        ChecksumWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "校验和不符; 跳过{bytes}字节, 其中{frames}帧"
            "the check sum does not match; {bytes} bytes with {frames} frames were passed over";
        StructureWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "长度或类型无效; 跳过{bytes}字节, 其中{frames}帧"
            "a length or type that cannot be; {bytes} bytes with {frames} frames were passed over";
        CompressionWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "压缩数据损坏; 跳过{bytes}字节, 其中{frames}帧"
            "compressed data are damaged; {bytes} bytes with {frames} frames were passed over";
    }

    /// The file ends in the middle of a record.
    Cap005 "CAP005" "capture-cut" Info "-" [] {
        message "文件在一条记录中间结束" "the file ends in the middle of a record";
        meaning
            "截断之前的内容都已读取; 正在写入的那条记录丢失。"
            "Everything before the cut is read; what was being written is lost.";
        cause
            "记录程序被终止, 或文件仍在写入、拷贝中。"
            "The recording program was ended, or the file is still being written or copied.";
        Cut { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "文件在一条记录中间结束; 此前的内容都已读取"
            "the file ends in the middle of a record; all before it is read";
    }

    /// A stamp is earlier than the one before: the clock was set.
    Cap006 "CAP006" "clock-set-back" Warning "-" [Sync, Time] {
        message "时间戳倒退" "time stamps go back";
        meaning
            "该帧的时间戳比同一总线上的前一帧早10毫秒以上: 时钟被调整过, 或者帧的顺序不对。跨越此处的时间不作判断。"
            "A frame's stamp is 10 ms or more earlier than that of the frame before on the same bus: the clock was set, or frames stand in the wrong order. Times across the step are not judged.";
        cause
            "主机时钟被调整(NTP、GPS或手动), 记录拼接的顺序不对, 或者记录被编辑过。"
            "The host's clock was set (NTP, GPS, by hand), recordings were joined out of order, or the recording was edited.";
        Back { back: Ns }
            "时间戳倒退{back}"
            "its stamp is {back} earlier";
    }

    /// Frames of some time are not in the recording, and nothing says so.
    Cap007 "CAP007" "recording-hole" Warning "-" [Sync, ErrorControl] {
        message "记录中有空缺" "the recording has a hole";
        meaning
            "该帧之前总线上没有任何报文, 而几个互不相关的节点此时都应发送; 之后它们又按原来的周期继续: 记录缺了这段时间的帧, 或者时钟被向前调整。跨越此处的内容不作判断。"
            "Nothing was on the bus before this frame, though several nodes that do not depend on each other had to send; then all go on in their periods: the frames of this time are not in the recording, or its clock was put on. Nothing is judged across it.";
        cause
            "接收缓冲区溢出, 适配器一时断开, 记录被暂停、剪去一段或拼接, 或者主机时钟被调整。"
            "A receive buffer overflowed, the adapter was disconnected for a while, the recording was paused, cut or joined, or the host's clock was set.";
        Silent { silence: Ns }
            "{silence}内没有任何帧, 而有几个节点应当发送; 之后都照常继续"
            "no frame for {silence}, though several nodes had to send; then all of them go on as before";
    }

    /// The file itself shows that rows are left out.
    Cap008 "CAP008" "rows-left-out" Warning "-" [] {
        message "记录中缺少一部分帧" "frames are left out of the capture";
        meaning
            "文件自身表明此处缺少帧: 行号不连续, 或者有省略标记。跨越此处的toggle位、序列号和应答不再判断, 进行中的传输记为不完整。"
            "The file itself shows that frames are missing here: its row numbers jump, or a mark says that rows were left out. Across the gap no toggle bit, sequence number or answer is judged, and open transfers are incomplete.";
        cause
            "摘录时删去了一部分, 列表按标识符筛选过, 或者记录程序丢帧。"
            "The excerpt was shortened, the listing was filtered, or the recording program lost frames.";
        Rows { rows: Count, last: Count, next: Count }
            "行号从{last}跳到{next}: 缺{rows}行"
            "row {last} is followed by row {next}: {rows|row is|rows are} missing";
        Counted { rows: Count }
            "此处注明略去{rows}行"
            "{rows|row is|rows are} left out, as it says here";
        Uncounted
            "此处略去了若干行, 未注明数目"
            "rows are left out here, how many is not told";
    }
}
