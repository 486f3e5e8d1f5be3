//! CiA 410: inclinometers.

use super::Object;
use super::Shape::Var;
use crate::od::DataType::{Integer16, Integer32, Unsigned8, Unsigned16};

pub(super) static OBJECTS: &[Object] = &[
    (0x6000, Var(Unsigned16), "分辨率", "resolution"),
    (0x6010, Var(Integer16), "纵向倾角(16位)", "slope long16"),
    (0x6011, Var(Unsigned8), "纵向倾角工作参数(16位)", "slope long16 operating parameter"),
    (0x6012, Var(Integer16), "纵向倾角预设值(16位)", "slope long16 preset value"),
    (0x6013, Var(Integer16), "纵向倾角偏移(16位)", "slope long16 offset"),
    (0x6014, Var(Integer16), "纵向倾角差分偏移(16位)", "differential slope long16 offset"),
    (0x6020, Var(Integer16), "横向倾角(16位)", "slope lateral16"),
    (0x6021, Var(Unsigned8), "横向倾角工作参数(16位)", "slope lateral16 operating parameter"),
    (0x6022, Var(Integer16), "横向倾角预设值(16位)", "slope lateral16 preset value"),
    (0x6023, Var(Integer16), "横向倾角偏移(16位)", "slope lateral16 offset"),
    (0x6024, Var(Integer16), "横向倾角差分偏移(16位)", "differential slope lateral16 offset"),
    (0x6110, Var(Integer32), "纵向倾角(32位)", "slope long32"),
    (0x6111, Var(Unsigned8), "纵向倾角工作参数(32位)", "slope long32 operating parameter"),
    (0x6112, Var(Integer32), "纵向倾角预设值(32位)", "slope long32 preset value"),
    (0x6113, Var(Integer32), "纵向倾角偏移(32位)", "slope long32 offset"),
    (0x6114, Var(Integer32), "纵向倾角差分偏移(32位)", "differential slope long32 offset"),
    (0x6120, Var(Integer32), "横向倾角(32位)", "slope lateral32"),
    (0x6121, Var(Unsigned8), "横向倾角工作参数(32位)", "slope lateral32 operating parameter"),
    (0x6122, Var(Integer32), "横向倾角预设值(32位)", "slope lateral32 preset value"),
    (0x6123, Var(Integer32), "横向倾角偏移(32位)", "slope lateral32 offset"),
    (0x6124, Var(Integer32), "横向倾角差分偏移(32位)", "differential slope lateral32 offset"),
];
