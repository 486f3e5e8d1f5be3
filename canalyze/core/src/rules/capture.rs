//! Rules about the capture itself: unreadable and missing parts.

use crate::bytes::ns::Ns;

use super::quantity::{Count, JsonOnly};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 这些内容既不是该格式的帧, 也不是注释; 其余内容照常解析。
    /// They are neither frames of the format nor comments; everything else is decoded normally.
    ///
    /// 文件被截断或编辑过, 混入了其他程序的输出, 或者是尚不支持的格式。
    /// The file was truncated or edited, holds another program's output, or is of an unsupported format.
    Cap001 "CAP001" "unreadable-lines" Warning "-" [] {
        message "有无法读取的行或记录" "lines or records that cannot be read";
        Lines { lines: Count } "{lines}行无法读取" "{lines|line|lines} cannot be read";
        OfFurtherBuses { lines: Count, further_buses: Count } "{lines}行无法读取, 其中{further_buses}行属于超出数量上限的总线"
            "{lines|line|lines} cannot be read, {further_buses} of them on buses beyond the limit";
    }

    /// 记录程序自己声明丢失了帧。丢帧处的toggle位、序列号和响应不再判断, 进行中的传输记为不完整。
    /// The recording program itself reports that it lost frames. Across the gap no toggle bit, sequence number or response is judged, and open transfers are incomplete.
    ///
    /// 接收缓冲区太小、主机太忙或存储太慢; candump可用 -r、dumpcap可用 -B 加大缓冲区, 其他记录程序见其缓冲设置。
    /// The receive buffer is too small, the host too busy or its disk too slow; use candump -r or dumpcap -B for a larger buffer; other programs have their own settings.
    Cap002 "CAP002" "dropped-frames" Warning "-" [] {
        message "记录程序丢帧" "frames lost by the recording program";
        Dropped { frames: Count, total: Count } "丢失{frames}帧 (累计{total}帧)" "{frames|frame|frames} lost (total {total})";
    }

    /// 管道中的时间戳按从零开始解释, 却出现倒退: 很可能是与前一帧的差值。
    /// The timestamps of the pipe were read as counted from zero, but one goes backwards: they are probably differences to the previous frame.
    ///
    /// candump使用了 -t d; 请加上 --stamps delta。
    /// candump was run with -t d; add --stamps delta.
    Cap003 "CAP003" "stamps-backward" Warning "-" [] {
        message "管道中的时间戳像是时间差" "timestamps of a pipe look like differences";
    }

    /// 损坏处前后可读的内容都已读取。缺口处不判断toggle位、序列号和响应, 未完成的传输记为不完整。校验和位于其所覆盖的数据之后, 不符时这些数据都可能有误。
    /// Everything readable before and after the damage is read. Across the gap no toggle bit, sequence number or response is judged, and open transfers are incomplete. A checksum follows the data it covers: where it does not match, all of that data may be wrong.
    ///
    /// 记录设备断电、存储介质出错, 或文件在传送中被改动; 请重新拷贝并比较校验和。
    /// The recording machine lost power, the storage has errors, or the file was changed in transfer; copy it again and compare checksums.
    Cap004 "CAP004" "damaged-capture" Warning "-" [] {
        message "文件有一部分损坏" "part of the file is damaged";
        Checksum { offset: JsonOnly<Option<Count>>, bytes: Option<Count> }
            "校验和不符; 跳过{bytes}字节" "checksum does not match; {bytes|byte|bytes} skipped";
        Structure { offset: JsonOnly<Option<Count>>, bytes: Option<Count> }
            "长度或类型无效; 跳过{bytes}字节" "invalid length or type; {bytes|byte|bytes} skipped";
        Compression { offset: JsonOnly<Option<Count>>, bytes: Option<Count> }
            "压缩数据损坏; 跳过{bytes}字节" "compressed data damaged; {bytes|byte|bytes} skipped";
        ChecksumUncounted { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "校验和不符; 跳过的字节数未知" "checksum does not match; unknown number of bytes skipped";
        StructureUncounted { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "长度或类型无效; 跳过的字节数未知" "invalid length or type; unknown number of bytes skipped";
        CompressionUncounted { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "压缩数据损坏; 跳过的字节数未知" "compressed data damaged; unknown number of bytes skipped";
        Rest { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "文件的其余部分无法读取" "the rest of the file cannot be read";
        Undefined { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "部分topic的定义已丢失或无法使用, 其消息已跳过" "messages skipped: the definition of their topic is lost or unusable";
        UndefinedWithFrames { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Count }
            "部分topic的定义已丢失或无法使用, 其{frames}条消息已跳过"
            "{frames|message|messages} skipped: the definition of their topic is lost or unusable";
        Doubtful { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: JsonOnly<Option<Count>> }
            "压缩数据损坏: 此后解压的内容都可能有误; 其后跳过{bytes}字节"
            "compressed data damaged: everything decompressed from here on may be wrong; the following {bytes|byte|bytes} skipped";
        DoubtfulWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "压缩数据损坏: 此后解压的{frames}帧都可能有误; 其后跳过{bytes}字节"
            "compressed data damaged: everything decompressed from here on ({frames|frame|frames}) may be wrong; the following {bytes|byte|bytes} skipped";
        Definition { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Option<Count> }
            "topic或类型的定义前后矛盾; 按第一个定义读取的{frames}帧可能有误"
            "definitions of a topic or type contradict each other: {frames|frame|frames} read by the first may be wrong";
        Missing { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Option<Count> }
            "按文件自身的统计, 还缺少{frames}条消息" "{frames|message|messages} missing according to the file's own statistics";
        Excess { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Option<Count> }
            "比文件自身的统计多{frames}条消息: 文件的一部分重复了"
            "{frames|message|messages} more than the file's own statistics count: a part of the file is there twice";
        Unlocated { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: Option<Count> }
            "全部数据的校验和不符, 损坏位置不明; 已读取的{frames}帧可能有误"
            "checksum over all data does not match, damaged place unknown: {frames|frame|frames} already read may be wrong";
        ChecksumWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "校验和不符; 跳过{bytes}字节, 其中{frames}帧"
            "checksum does not match; {bytes|byte|bytes} with {frames|frame|frames} skipped";
        StructureWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "长度或类型无效; 跳过{bytes}字节, 其中{frames}帧"
            "invalid length or type; {bytes|byte|bytes} with {frames|frame|frames} skipped";
        CompressionWithFrames { offset: JsonOnly<Option<Count>>, bytes: Option<Count>, frames: Count }
            "压缩数据损坏; 跳过{bytes}字节, 其中{frames}帧"
            "compressed data damaged; {bytes|byte|bytes} with {frames|frame|frames} skipped";
    }

    /// 截断之前的内容都已读取; 正在写入的那条记录丢失。
    /// Everything before the cut was read; the record being written is lost.
    ///
    /// 记录程序被终止, 或文件仍在写入、拷贝中。
    /// The recording program was terminated, or the file is still being written or copied.
    Cap005 "CAP005" "capture-cut" Info "-" [] {
        message "文件在一条记录中间结束" "file ends in the middle of a record";
        Cut { offset: JsonOnly<Option<Count>>, bytes: JsonOnly<Option<Count>>, frames: JsonOnly<Option<Count>> }
            "文件在一条记录中间结束; 此前的内容都已读取" "file ends in the middle of a record; everything up to there was read";
    }

    /// 该帧的时间戳比同一总线上的前一帧早超过10 ms: 时钟被调整过, 或者帧的顺序不对。跨越此处的时间不作判断。
    /// The frame's timestamp is more than 10 ms earlier than that of the previous frame on the same bus: the clock was set, or frames are in the wrong order. Times across the step are not judged.
    ///
    /// 主机时钟被调整(NTP、GPS或手动), 记录拼接的顺序不对, 或者记录被编辑过。
    /// The host's clock was set (NTP, GPS, by hand), recordings were joined out of order, or the recording was edited.
    Cap006 "CAP006" "clock-set-back" Warning "-" [Sync, Time] {
        message "时间戳倒退" "timestamp goes back";
        Back { back: Ns } "时间戳倒退{back}" "timestamp goes back {back}";
    }

    /// 该帧之前总线上没有任何报文, 而几个互不相关的节点此时都应发送; 之后它们又按原周期继续: 这段时间的帧没有录到, 或者时钟被向前调整。跨越此处的内容不作判断。
    /// There was no traffic before this frame although several independent nodes should have sent; then all continue with their periods: the frames of this time were not recorded, or the clock was set forward. Nothing is judged across the gap.
    ///
    /// 接收缓冲区溢出, 适配器一时断开, 记录被暂停、剪去一段或拼接, 或者主机时钟被调整。
    /// A receive buffer overflowed, the adapter was disconnected for a while, the recording was paused, cut or joined, or the host's clock was set.
    Cap007 "CAP007" "recording-hole" Warning "-" [Sync, ErrorControl] {
        message "记录中有空缺" "gap in the recording";
        Silent { silence: Ns } "{silence}内没有任何帧, 而有几个节点应发送报文; 之后都照常继续"
            "no frame for {silence} although several nodes should have sent; then all continue as before";
    }

    /// 文件自身表明此处缺少帧: 行号不连续, 或者有省略标记。跨越此处的toggle位、序列号和响应不再判断, 进行中的传输记为不完整。
    /// The file itself shows that frames are missing here: its row numbers jump, or a mark shows omitted rows. Across the gap no toggle bit, sequence number or response is judged, and open transfers are incomplete.
    ///
    /// 摘录时删去了一部分, 列表按标识符筛选过, 或者记录程序丢帧。
    /// The excerpt was shortened, the listing was filtered, or the recording program lost frames.
    Cap008 "CAP008" "rows-left-out" Warning "-" [] {
        message "记录中缺少一部分帧" "frames left out of the capture";
        Rows { rows: Count, last: Count, next: Count }
            "行号从{last}跳到{next}: 缺{rows}行" "row {last} is followed by row {next}: {rows|row is|rows are} missing";
        Counted { rows: Count } "此处注明略去{rows}行" "{rows|row|rows} marked as omitted here";
        Uncounted "此处略去若干行, 未注明行数" "rows omitted here, number unknown";
    }

    /// 多个互不相关的发送方各自缺少个别按周期发送的报文, 时间各不相同, 而总线上的通信照常继续, 周期和相位也都不变: 这些帧没有录到。此后, 按这个丢失比例可以解释的判断都归因于此。
    /// Several independent senders each lack single frames that they send by time, at different times, while the traffic goes on and all keep their periods and phases: these frames were not recorded. From here on, findings that losses at this rate explain are consequences.
    ///
    /// 适配器或驱动程序的接收缓冲区太小, 主机太忙, 或者USB、网络转发丢包; 请加大缓冲区, 或用另一个适配器重新记录。
    /// The receive buffer of the adapter or its driver is too small, the host is too busy, or USB or a network gateway drops packets; use a larger buffer, or record again with another adapter.
    Cap009 "CAP009" "frames-lost" Warning "-" [Sync, ErrorControl] {
        message "记录中零散地缺少帧" "single frames are missing from the capture";
        Single { missing: Count, due: Count }
            "按周期应有的{due}个同步或心跳报文中缺少{missing}个, 分属不同发送方和时刻: 记录丢帧"
            "{missing} of {due} SYNCs and heartbeats that were due are missing, of several senders or although answered: the recording loses frames";
    }
}
