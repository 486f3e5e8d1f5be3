//! The checks of `build.rs`: each fault in a table of `words/` is found, in its line.

#[path = "../build.rs"]
#[allow(dead_code, reason = "its main is cargo's")]
mod build;

#[test]
fn rows_become_rust() {
    for (table, rust) in [
        ("# Bits.\nvalue\tzh\ten\n0\t接通\tswitch on\n", "&[\n\n(0, \"接通\", \"switch on\"),\n]"),
        ("State\tzh\ten\nFault\t故障\tfault\n", "&[\n(State::Fault, \"故障\", \"fault\"),\n]"),
        ("range\tclause\n1000\tA\n1200-127F\tB\n", "&[\n(0x1000, 0x1000, \"A\"),\n(0x1200, 0x127F, \"B\"),\n]"),
        (
            "index\tsub\ttype\tzh\ten\n6000\t\tRECORD\t值\ta\n6000\t1\tTIME_OF_DAY\t值\tb\n6001\t\tREAL32[]\t值\tc\n",
            "&[\n(0x6000, Record, \"值\", \"a\", &[\n(1, TimeOfDay, \"值\", \"b\"),\n]),(0x6001, Array(Real32), \"值\", \"c\", &[\n])]",
        ),
        (
            "names\tcodes\tend.zh\tend.en\na, b\tSDO001, HBT002\n\t值\t\"c\"\n",
            "&[\n\n(&[\"a\", \"b\"], &[Code::Sdo001, Code::Hbt002], Words { zh: \"值\", en: \"\\\"c\\\"\" }),\n]",
        ),
    ] {
        assert_eq!(build::rows(table).as_deref(), Ok(rust));
    }
}

#[test]
fn faults_are_found() {
    for (table, line, fault) in [
        ("value\tzh\ten\n1\t值\n", 2, "2 cells for 3 columns"),
        ("value\tzh\ten\n1\t\ta\n", 2, "zh: '' does not fit"),
        ("value\tzh\ten\n1\t值\t\n", 2, "en: '' does not fit"),
        ("value\tzh\ten\n1\tabc\ta\n", 2, "zh: 'abc' does not fit"),
        ("value\tzh\ten\n1\t值，\ta\n", 2, "zh: '值，' does not fit"),
        ("value\tzh\ten\n1\t值\t值\n", 2, "en: '值' does not fit"),
        ("value\tzh\ten\n1\t值\ta \n", 2, "en: 'a ' does not fit"),
        ("value\tzh\ten\n\n#\n1\t值\ta\n1\t值\tb\n", 5, "is there already, or not in order"),
        ("value\tzh\ten\n2\t值\ta\n1\t值\tb\n", 3, "is there already, or not in order"),
        ("value\tzh\ten\nx\t值\ta\n", 2, "value: 'x' does not fit"),
        ("index\tzh\ten\n600\t值\ta\n", 2, "index: '600' does not fit"),
        ("code\tzh\ten\n60000\t值\ta\n", 2, "code: '60000' does not fit"),
        ("code\tzh\ten\n600G\t值\ta\n", 2, "code: '600G' does not fit"),
        ("range\tclause\n1001-1000\tA\n", 2, "is there already, or not in order"),
        ("range\tclause\n1000-1003\tA\n1003\tB\n", 3, "is there already, or not in order"),
        ("range\tsub\tzh\ten\n1000\t1\t值\ta\n", 2, "is there already, or not in order"),
        ("range\tsub\tzh\ten\n1000\t\t值\ta\n1001\t1\t值\ta\n", 3, "is there already, or not in order"),
        ("range\tsub\tzh\ten\n1000\t\t值\ta\n1000\t1\t值\ta\n1000\t1\t值\ta\n", 4, "is there already, or not in order"),
        ("State\tzh\ten\nFault\t值\ta\nFault\t值\n\tb\n", 4, "is there already, or not in order"),
    ] {
        assert_eq!(build::rows(table), Err((line, fault.to_owned())), "{table}");
    }
}
