"""XDD and XDC (CiA 311), the XML form of a description -> the same sections as those of an EDS.

Only what an EDS says too is taken: device, file, objects with their parameters, dummies, bit rates. A document type
declaration is refused, since nothing here needs one and entities can blow a small file up.
"""

from typing import Final, NoReturn
from xml.parsers import expat

from canalyze.dictionary.ini import Ini, Key, Section
from canalyze.errors import SourceError

_TYPES: Final = {
    "BOOL": 0x01,
    "SINT": 0x02,
    "INT": 0x03,
    "DINT": 0x04,
    "LINT": 0x15,
    "USINT": 0x05,
    "BYTE": 0x05,
    "UINT": 0x06,
    "WORD": 0x06,
    "UDINT": 0x07,
    "DWORD": 0x07,
    "ULINT": 0x1B,
    "LWORD": 0x1B,
    "REAL": 0x08,
    "LREAL": 0x11,
    "CHAR": 0x09,
    "STRING": 0x09,
    "WSTRING": 0x0B,
    "BITSTRING": 0x0A,
}
"""Elements that name a data type."""
_ACCESSES: Final = {
    "const": "const",
    "read": "ro",
    "write": "wo",
    "noAccess": "ro",
    "readWrite": "rw",
    "readWriteInput": "rwr",
    "readWriteOutput": "rww",
}
_VALUES: Final = {"defaultValue": "DefaultValue", "actualValue": "ParameterValue"}
_LIMITS: Final = {"minValue": "LowLimit", "maxValue": "HighLimit"}
_ATTRIBUTES: Final = {
    "name": "ParameterName",
    "accessType": "AccessType",
    "defaultValue": "DefaultValue",
    "actualValue": "ParameterValue",
    "lowLimit": "LowLimit",
    "highLimit": "HighLimit",
}
"""Of an object, for keys of its section; they overrule the parameter that the object refers to."""
_IDENTITY: Final = {
    "vendorName": "VendorName",
    "vendorID": "VendorNumber",
    "productName": "ProductName",
    "productID": "ProductNumber",
    "orderNumber": "OrderCode",
}
_FILE: Final = {
    "fileName": "FileName",
    "fileVersion": "FileVersion",
    "fileCreator": "CreatedBy",
    "fileCreationDate": "CreationDate",
    "fileCreationTime": "CreationTime",
    "fileModifiedBy": "ModifiedBy",
    "fileModificationDate": "ModificationDate",
    "fileModificationTime": "ModificationTime",
}
_FEATURES: Final = {
    "nrOfRxPDO": "NrOfRXPDO",
    "nrOfTxPDO": "NrOfTXPDO",
    "layerSettingServiceSlave": "LSS_Supported",
}
_FLAGS: Final = {"true": "1", "false": "0"}


def sections(data: bytes, name: str) -> Ini:
    """Read a document; SourceError if it is not well-formed."""
    document = _Document(name)
    try:
        document.parser.Parse(data, True)
    except expat.ExpatError as error:
        problem = expat.ErrorString(error.code)
        raise SourceError("eds.xml", name=name, line=error.lineno, problem=problem) from error
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        raise SourceError("eds.xml", name=name, line=1, problem=error) from error
    return document.ini()


class _Document:
    """What the elements of one document said."""

    def __init__(self, name: str) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._characters
        self.parser.StartDoctypeDeclHandler = self._doctype
        self._name = name
        self._ini = Ini()
        self._parameters: dict[str, dict[str, str]] = {}
        self._parameter: dict[str, str] | None = None
        self._references: list[tuple[Section, str]] = []
        self._index = ""
        self._identity = ""

    def ini(self) -> Ini:
        """Give the sections, objects with the parameters they refer to."""
        for section, reference in self._references:
            for key, value in self._parameters.get(reference, {}).items():
                section.keys.setdefault(key.lower(), Key(key, value, section.line))
            if section.get("DataType"):
                section.keys.setdefault("accesstype", Key("AccessType", "ro", section.line))
        return self._ini

    def _doctype(self, *_: object) -> NoReturn:
        raise SourceError("eds.doctype", name=self._name)

    def _put(self, section: str, key: str, value: str) -> None:
        line = self.parser.CurrentLineNumber
        found = self._ini.sections.setdefault(section.lower(), Section(section, line))
        found.keys[key.lower()] = Key(key, value.strip(), line)

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        tag = name.rpartition(":")[2]
        if tag == "CANopenObject":
            self._index = attributes.get("index", "")
            self._object(self._index, attributes)
        elif tag == "CANopenSubObject":
            self._object(f"{self._index}sub{attributes.get('subIndex', '')}", attributes)
        elif tag == "parameter":
            access = _ACCESSES.get(attributes.get("access", "read"), "ro")
            self._parameter = self._parameters.setdefault(attributes.get("uniqueID", ""), {"AccessType": access})
        elif self._parameter is not None:
            self._of_parameter(tag, attributes)
        elif tag in _IDENTITY:
            self._identity = _IDENTITY[tag]
        else:
            self._of_device(tag, attributes)

    def _of_parameter(self, tag: str, attributes: dict[str, str]) -> None:
        assert self._parameter is not None
        value = attributes.get("value", "")
        if tag in _TYPES:
            self._parameter["DataType"] = f"{_TYPES[tag]:#06x}"
        elif tag in _VALUES:
            self._parameter[_VALUES[tag]] = _FLAGS.get(value, value)
        elif tag in _LIMITS:
            self._parameter[_LIMITS[tag]] = value

    def _of_device(self, tag: str, attributes: dict[str, str]) -> None:
        if tag == "ProfileBody":
            for attribute, key in _FILE.items():
                if attribute in attributes:
                    self._put("FileInfo", key, attributes[attribute])
        elif tag == "dummy":
            key, _, value = attributes.get("entry", "").partition("=")
            self._put("DummyUsage", key, value)
        elif tag == "supportedBaudRate":
            self._put("DeviceInfo", "BaudRate_" + attributes.get("value", "").partition(" ")[0], "1")
        elif tag == "CANopenGeneralFeatures":
            for attribute, key in _FEATURES.items():
                if attribute in attributes:
                    self._put("DeviceInfo", key, _FLAGS.get(attributes[attribute], attributes[attribute]))
        elif tag == "deviceCommissioning":
            for attribute in attributes:
                self._put("DeviceComissioning", attribute, attributes[attribute].removesuffix(" Kbps"))

    def _object(self, name: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        section = Section(name, line)
        given = {key: attributes[attribute] for attribute, key in _ATTRIBUTES.items() if attribute in attributes}
        given["ObjectType"] = attributes.get("objectType", "7")
        given["PDOMapping"] = "0" if attributes.get("PDOmapping", "no") == "no" else "1"
        if "dataType" in attributes:
            given["DataType"] = f"0x{attributes['dataType'].removeprefix('0x')}"
        if "subNumber" in attributes:
            given["SubNumber"] = attributes["subNumber"]
        section.keys = {key.lower(): Key(key, value.strip(), line) for key, value in given.items()}
        if name.lower() in self._ini.sections:
            self._ini.complain(
                line, "duplicate-section", section=name[:60], first=self._ini.sections[name.lower()].line
            )
        self._ini.sections[name.lower()] = section
        self._references.append((section, attributes.get("uniqueIDRef", "")))

    def _characters(self, text: str) -> None:
        if self._identity and text.strip():
            self._put("DeviceInfo", self._identity, text)

    def _end(self, name: str) -> None:
        self._identity = ""
        if name.rpartition(":")[2] == "parameter":
            self._parameter = None
