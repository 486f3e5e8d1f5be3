//! Rules about differences between a description (EDS or DCF) and its device.

use super::quantity::{Count, Hex8, Quantity};
use super::{Verdict, rules};

rules! {
    Verdict:

    /// 在记录中还没有写过该参数, 读到的值就与EDS的默认值不同, 或者PDO从一开始就与EDS的默认映射长度不同。
    /// The parameter was not written in the capture before, and the value read is not the EDS's default; or from the beginning a PDO is not as long as the EDS's default mapping.
    ///
    /// 设备在记录开始之前已被配置或存储过参数, EDS与固件版本不符, 或者EDS不是这台设备的。
    /// The device was configured or stored its parameters before the capture began, or the EDS is of another firmware or another device.
    Eds001 "EDS001" "differs-from-eds" Info "CiA 306" [Sdo] {
        message "读到的值与EDS的默认值不同" "value read differs from the EDS's default";
        Value { found: Quantity, described: Quantity }
            "读到{found}, EDS的默认值为{described}" "read {found}, EDS default is {described}";
        PdoLength { found: Count, mapped: Count }
            "PDO为{found}字节, EDS的默认映射为{mapped}字节: 设备在记录开始前已被配置, 或者EDS不是这台设备的"
            "PDO is {found|byte|bytes}, the EDS's default mapping has {mapped}: the device was configured before the capture began, or the EDS is for another device";
    }

    /// 在记录中还没有写过该参数, 读到的值就与DCF配置的值不同。
    /// The parameter was not written in the capture before, and the value read is not what the DCF configures.
    ///
    /// 设备没有按这份DCF配置, 或者配置在复位后丢失。
    /// The device is not configured by this DCF, or lost its configuration in a reset.
    Eds002 "EDS002" "differs-from-dcf" Warning "CiA 306" [Sdo] {
        message "读到的值与DCF不同" "value read differs from the DCF";
        Value { found: Quantity, described: Quantity }
            "读到{found}, DCF配置为{described}" "read {found}, DCF has {described}";
    }

    /// 访问成功了, 但设备描述中没有这个索引或子索引。
    /// The access succeeded, but the device's description has no such index or sub-index.
    ///
    /// EDS与固件版本不符, 或者制造商没有把该对象写进EDS。
    /// The EDS is of another firmware, or the vendor left the object out of it.
    Eds003 "EDS003" "not-in-description" Info "CiA 306" [Sdo] {
        message "设备描述中没有该对象" "object is not in the description";
        Index "访问成功, 但设备描述中没有该索引" "index accessed that the description does not list";
        SubIndex "访问成功, 但设备描述中该索引没有这个子索引" "sub-index accessed that the description does not list";
    }

    /// 设备类型(1000h)、制造商ID或产品码(1018h)与设备描述中的不同: 这份描述很可能不是这台设备的。或者与主站的描述所要求的(1F84h到1F88h)不同: 启动检查不通过。
    /// Device type (1000h), vendor-ID or product code (1018h) are not those of the description: it probably is that of another device. Or they are not what the description of the controller expects (1F84h to 1F88h): the boot check fails.
    ///
    /// 给节点指定了错误的EDS, 节点ID弄混, 或者更换了设备。
    /// The wrong EDS was given for the node, node-IDs were mixed up, or the device was replaced.
    Eds004 "EDS004" "identity-differs" Warning "CiA 306" [Sdo] {
        message "设备标识与设备描述不符" "identity differs from the description";
        Value { found: Quantity, described: Quantity } "读到{found}, 设备描述中为{described}: EDS很可能不是这台设备的"
            "read {found}, the description has {described}: the EDS is probably for another device";
        Expected { found: Hex8, expected: Hex8, controller: Count } "读到{found}, 主站节点{controller}要求{expected} (1F84h到1F88h): 启动检查不通过"
            "read {found}, the controller (node {controller}) expects {expected} (1F84h to 1F88h): the boot check fails";
    }

    /// 设备以中止码06020000h或06090011h回答: 没有这个对象或子索引, 而设备描述中有。
    /// The device answers with abort code 06020000h or 06090011h that there is no such object or sub-index, but the description lists it.
    ///
    /// EDS与固件版本不符, 或者EDS是为整个系列写的, 这台设备没有该选件。
    /// The EDS is of another firmware, or of a whole series of which this device lacks an option.
    Eds005 "EDS005" "not-in-device" Info "CiA 306" [Sdo] {
        message "设备中没有设备描述中的对象" "object of the description is not in the device";
        Index "设备中没有该索引, 而设备描述中有" "the device has no such index, but the description lists it";
        SubIndex "设备中没有该子索引, 而设备描述中有" "the device has no such sub-index, but the description lists it";
    }
}
