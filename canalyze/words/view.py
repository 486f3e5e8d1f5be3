"""What `canalyze view` says of itself, and what `sniff` says of a viewer: help, options, errors.

Rows (key, zh, en), as the folder's `__init__` has it; nothing else.
"""

from typing import Final

ROWS: Final[tuple[tuple[str, str, str], ...]] = (
    ("view.short", "在 Rerun 的时间轴上查看记录", "Show a capture as a timeline, in Rerun"),
    ("view.usage", "[选项] [文件...]", "[OPTIONS] [FILE...]"),
    (
        "view.help",
        "把记录显示为时间轴：各节点的NMT状态、SDO传输、CiA 402状态、EMCY、枚举和位的状态带，PDO信号、同步周期和总线负载"
        "的曲线，发现和EMCY的日志，逐帧注释，以及摘要；可按记录时间、经过时间、帧号或同步周期查看。"
        "在窗口中打开 Rerun 的查看器，关闭窗口或按Ctrl-C结束；--web 改为在浏览器中显示，--save 写成文件，"
        "以后用 canalyze view 文件.rrd 打开。没有给出文件时读标准输入。"
        "查看器只在127.0.0.1上监听，既不发送使用统计，也不检查新版本；但 --web 的页面在浏览器里运行，"
        "浏览器若能上网，Rerun 的页面会取字体并发送使用统计。打开前先写在临时文件夹里（TMPDIR），关闭后删除。"
        "需要安装：pip install 'canalyze[rerun]'。",
        "Show a capture as a timeline: lanes of each node's NMT state, SDO transfers, CiA 402 state, EMCY, choices and "
        "bits; plots of PDO signals, SYNC period and bus load; logs of findings and EMCYs; the annotated frames; a "
        "summary. It can be gone through by time of the capture, elapsed time, frame, or SYNC cycle. Rerun's viewer "
        "opens in a window; closing it, or Ctrl-C, is the end. --web shows it in a browser instead, --save writes a "
        "file that canalyze view FILE.rrd opens later. Without a file, standard input is read. The viewer listens on "
        "127.0.0.1 only, sends no usage data and does not look for new versions; but the page of --web runs in the "
        "browser: where that reaches the internet, Rerun's page fetches a font and sends usage data. What is "
        "shown is written to the folder for temporary files (TMPDIR) and goes when the viewer is closed. It needs: "
        "pip install 'canalyze[rerun]'.",
    ),
    (
        "view.save",
        "写成 Rerun 的文件（.rrd），不打开查看器；先写在旁边，完成后才改名。文件名以 .rbl 结尾时，"
        "只写出布局，供 Rerun 直接打开 convert --decoded 写出的MCAP时使用。",
        "Write a file for Rerun (.rrd) and open no viewer; it is written beside and renamed when complete. A name in "
        ".rbl gets a layout alone, by which Rerun itself opens an MCAP that convert --decoded wrote.",
    ),
    (
        "view.web",
        "在浏览器中显示，不打开窗口：给出网址，直到Ctrl-C为止。",
        "Show it in a browser instead of a window: its address is told; Ctrl-C is the end.",
    ),
    (
        "view.bind",
        "查看器监听的地址；不给则为127.0.0.1，只有本机能访问。没有密码：能访问该地址的人都能看到并写入。",
        "Address on which the viewer listens; without it 127.0.0.1, which only this machine reaches. There is no "
        "password: whoever reaches the address can see everything, and write to it.",
    ),
    (
        "view.port",
        "查看器的端口；不给则取空闲的。用 --web 时是网页的端口，数据用下一个端口。",
        "Port of the viewer; without it a free one. With --web it is that of the page, and the next one carries the "
        "data.",
    ),
    (
        "view.examples",
        "canalyze view capture.log\n"
        "canalyze view --eds 5=drive.eds --filter 'node=5' capture.log.gz\n"
        "canalyze view --save capture.rrd capture.asc && canalyze view capture.rrd\n"
        "canalyze view --web --port 9090 capture.mcap\n"
        "canalyze view --save out.rbl out.mcap\n"
        "canalyze sniff can0 --rerun",
        "canalyze view capture.log\n"
        "canalyze view --eds 5=drive.eds --filter 'node=5' capture.log.gz\n"
        "canalyze view --save capture.rrd capture.asc && canalyze view capture.rrd\n"
        "canalyze view --web --port 9090 capture.mcap\n"
        "canalyze view --save out.rbl out.mcap\n"
        "canalyze sniff can0 --rerun",
    ),
    (
        "sniff.rerun",
        "同时在 Rerun 的查看器里显示为时间轴（见 canalyze view --help）；查看器慢、停住或被关闭，监听都照常进行。",
        "Show it as a timeline in Rerun's viewer meanwhile (see canalyze view --help); listening goes on whether the "
        "viewer is slow, stuck or closed.",
    ),
    (
        "sniff.save",
        "把时间轴写成 Rerun 的文件（.rrd），边收边写；可与 --rerun 一起用，也可单独用。",
        "Write the timeline to a file for Rerun (.rrd) as it comes; with --rerun or by itself.",
    ),
    ("sniff.needs_rerun", "{option} 要与 {other} 一起用", "{option} goes with {other}"),
    # What is told while it runs.
    ("view.viewer", "查看器", "the viewer"),
    ("view.page", "在浏览器中打开 {url}", "open in a browser: {url}"),
    ("view.until", "Ctrl-C结束", "Ctrl-C ends it"),
    (
        "view.exposed",
        "查看器在 {address} 上监听，没有密码：能访问该地址的人都能看到并写入",
        "the viewer listens on {address} without a password: whoever reaches it can see everything, and write to it",
    ),
    (
        "view.closed",
        "查看器已关闭，监听继续",
        "the viewer was closed; listening goes on",
    ),
    (
        "view.lost",
        "查看器自行结束（它报告：{problem}），监听继续",
        "the viewer ended by itself (it says: {problem}); listening goes on",
    ),
    (
        "view.stays",
        "查看器仍然开着；关闭窗口或按Ctrl-C结束",
        "the viewer stays open; closing it, or Ctrl-C, is the end",
    ),
    ("view.stays_page", "{url} 仍可查看；Ctrl-C结束", "{url} stays; Ctrl-C is the end"),
    ("view.written", "{name}：时间轴，{size} MB", "{name}: timeline, {size} MB"),
    (
        "view.left_out",
        "查看器太慢，时间轴有{count}行没有送到；列出和记录的内容不受影响",
        "the viewer was too slow: {count} rows of the timeline did not get there; the listing and recordings have them",
    ),
    (
        "view.left_out_file",
        "{name}：写入太慢，时间轴缺少{count}行；列出和记录的内容不受影响",
        "{name}: writing was too slow, {count} rows of the timeline are missing; the listing and recordings have them",
    ),
    # What goes wrong.
    (
        "view.missing",
        "时间轴需要 Rerun，尚未安装；安装：pip install 'canalyze[rerun]'",
        "a timeline needs Rerun, which is not installed: pip install 'canalyze[rerun]'",
    ),
    (
        "view.no_display",
        "这里没有显示器，不能打开窗口；用 --web 在浏览器中显示，或用 --save 文件.rrd 写成文件",
        "there is no display for a window; --web shows it in a browser, --save FILE.rrd writes it to a file",
    ),
    (
        "view.start",
        "查看器不能启动：{error}",
        "the viewer cannot be started: {error}",
    ),
    (
        "view.died",
        "查看器自行结束（它报告：{problem}）；用 --web 在浏览器中显示，或用 --save 文件.rrd 写成文件",
        "the viewer ended by itself (it says: {problem}); --web shows it in a browser, --save FILE.rrd writes it to a "
        "file",
    ),
    (
        "view.silent",
        "查看器在{seconds}秒内没有准备好；用 --save 文件.rrd 写成文件",
        "the viewer was not ready within {seconds} s; --save FILE.rrd writes it to a file",
    ),
    (
        "view.port_taken",
        "查看器不能在 {address} 的端口 {port} 上监听：{error}；用 --port 换一个",
        "the viewer cannot listen on {address}, port {port}: {error}; --port names another",
    ),
    (
        "view.no_address",
        "查看器不能在 {address} 上监听：{error}；用 --bind 给出本机的地址",
        "the viewer cannot listen on {address}: {error}; --bind has to name an address of this machine",
    ),
    (
        "view.broken",
        "{name}：时间轴中断：{problem}",
        "{name}: the timeline is broken off: {problem}",
    ),
    (
        "view.suffix",
        "--save 的文件名 {name} 要以 .rrd 结尾，如 capture.rrd",
        "--save: {name} has to end in .rrd, as capture.rrd",
    ),
    (
        "view.ready",
        "{name}：已经是时间轴；单独打开：canalyze view {name}",
        "{name}: is a timeline already; canalyze view {name} opens it, by itself",
    ),
    (
        "view.a_layout",
        "{name}：是布局，不是记录；Rerun 打开MCAP时使用：rerun --bind 127.0.0.1 out.mcap - < {name}",
        "{name}: is a layout, no capture; rerun --bind 127.0.0.1 out.mcap - < {name} opens an MCAP with it",
    ),
    (
        "view.too_late",
        "选项 {option} 对已经写好的时间轴不起作用；对记录使用",
        "option {option} does nothing to a timeline that is ready; use it with the capture",
    ),
    (
        "view.no_timeline",
        "{name}：不是 Rerun 的文件",
        "{name}: is no file of Rerun's",
    ),
    (
        "usage.bind",
        "选项 {option} 不能是 {value}，应为IP地址，如 127.0.0.1",
        "option {option}: {value} is no IP address, such as 127.0.0.1",
    ),
    (
        "usage.port",
        "选项 {option} 不能是 {value}，可以是1024到65534",
        "option {option}: {value} is no port from 1024 to 65534",
    ),
)
