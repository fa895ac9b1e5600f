"""What an emulated LMS2xx keeps when it is switched off."""

from dataclasses import dataclass

AT_DELIVERY = 9600  # [Bd]

# Of a real LMS200-S18063, V02.19: 180 degrees in steps of 0.5, 16 m in millimetres.
STATUS = bytes.fromhex(
    "5630322e3139202500303532373034393700910100001a010000de0100009902000077011001c001"
    "4601b00152026701ee01d801d80194028b0365016501b201b2019400010001000200000001000000"
    "00009c0025010c0b2601800a9903990399039903080400030002b400320002000000011980020000"
    "0101015630322e303220c89c0700f8bf1e00b8a2070030c51e0052068e065802"
)
CONFIGURATION = bytes.fromhex(
    "00007000000401000002020000000000000000000000000000000000000000000200"
)


@dataclass
class Memory:
    """The EEPROM of an LMS2xx, and what is printed on its plate.

    Parameters
    ----------
    device_type : bytes
        21 characters; with ``S14`` it is a fast one, which refuses other fields of view.
    configuration : bytes
        32 or 34 bytes, as an F4 sends them.
    angle : int
        Field of view [degrees].
    resolution : int
        Step from value to value [1/100 degree].
    baud : int
        Rate of the line at power-on [Bd].
    keeps_baud : bool
        Whether that is the rate at which it was told to keep it.
    status : bytes
        Data of the B1, in which the emulator replaces what it knows better.
    errors : bytes
        Data of the B2: pairs of type and number.
    writes : int
        How often it has been written to; the real one lives for some thousand times.
    """

    device_type: bytes = b"LMS200;S18063;V02.19 "
    configuration: bytes = CONFIGURATION
    angle: int = 180
    resolution: int = 50
    baud: int = AT_DELIVERY
    keeps_baud: bool = False
    status: bytes = STATUS
    errors: bytes = b""
    writes: int = 0
