"""Mutations of the bytes of a file in any format: its numbers, its texts, its lines and its bytes."""

import gzip
import random
import re
from collections.abc import Callable

NUMBERS = (
    "0", "-1", "1e308", "-1e308", "1e-308", "1e-12", "nan", "-nan", "inf", "-inf", "Infinity", "1e400", "9" * 310,
    "9" * 5000, str(2**31), str(2**53), str(2**63), str(2**70), "300000000", "-0", "0x10", "1_000", "1,5", "1e", "+",
    "", "\u0663", "\u00bd", "true", "null", "1e10", "-1e10", "0.0000001", "1e7", "[]", "[[1]]",
    "{}", '"1"', "1e5", "65536",
)  # fmt: skip
TEXTS = (
    "", " ", "x" * 5000, "../" * 1700, "a/" * 2500, "\x1b[31mred", "\x07\x08", "\u202e", "\U0001f697", "\0", "a\nb",
    "\r", "%s%n", "{0}", "[bold]", "NA", "nan", "None", "/dev/null", "/dev/zero", "/", ".", "..",
    "\ufeff", "\u2028", "\\",
    "'", "&lt;", "&#0;", "]]>", "-1", "1e999", "\x9b31m", "\ud7ff", "e\u0301" * 100, "#", "=", ",",
    ";", "true", "*", "~",
    "$HOME",
)  # fmt: skip
DEEP = ("[", "{", "(", "<a>", '{"a":', "[[", '"', "{a=", "<!--", "a.")
BOMB = '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa">{}]>'.format(
    "".join(f'<!ENTITY {b} "{10 * f"&{a};"}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
)
OUTSIDE = '<!DOCTYPE a [<!ENTITY i SYSTEM "file:///etc/hostname">]>'

Way = Callable[[random.Random, bytes], bytes]


def mutated(rng: random.Random, content: bytes, ways: tuple[Way, ...]) -> tuple[bytes, str]:
    """Return the content with one to three mutations, and their names."""
    names = []
    for way in rng.choices(ways, k=rng.choice((1, 1, 1, 2, 3))):
        content = way(rng, content)
        names.append(way.__name__.strip("_"))
    return content, " ".join(names)


def _replace_one(rng: random.Random, content: bytes, pattern: bytes, values: tuple[str, ...]) -> bytes:
    found = list(re.finditer(pattern, content))
    if not found:
        return content + rng.choice(values).encode(errors="surrogatepass")
    start, end = rng.choice(found).span(1)
    return content[:start] + rng.choice(values).encode(errors="surrogatepass") + content[end:]


def _number(rng, content):
    return _replace_one(rng, content, rb"(-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)", NUMBERS)


def _text(rng, content):
    return _replace_one(rng, content, rb'"([^"\n]*)"', (*TEXTS, *NUMBERS))


def _word(rng, content):
    return _replace_one(rng, content, rb"([A-Za-z_][\w.-]*)", TEXTS)


def _all_of_a_number(rng, content):
    """Replace every occurrence of a number."""
    found = re.findall(rb"\d+(?:\.\d+)?", content) or [b"1"]
    return content.replace(rng.choice(found), rng.choice(NUMBERS).encode())


def _insert(rng, content):
    at = rng.randrange(len(content) + 1)
    return content[:at] + rng.choice((*TEXTS, *NUMBERS, *DEEP)).encode(errors="surrogatepass") + content[at:]


def _deep(rng, content):
    at = rng.randrange(len(content) + 1)
    return content[:at] + rng.choice(DEEP).encode() * rng.choice((100, 2000, 100_000)) + content[at:]


def _flip(rng, content):
    raw = bytearray(content)
    for _ in range(rng.choice((1, 1, 3, 20)) if raw else 0):
        raw[rng.randrange(len(raw))] = rng.choice((0, 1, 127, 128, 255, rng.randrange(256)))
    return bytes(raw)


def _truncate(rng, content):
    return content[: rng.randrange(len(content) + 1)]


def _behead(rng, content):
    return content[rng.randrange(len(content) + 1) :]


def _cut_out(rng, content):
    begin = rng.randrange(len(content) + 1)
    return content[:begin] + content[begin + rng.choice((1, 2, 4, 8, 100)) :]


def _repeat(rng, content):
    begin = rng.randrange(len(content) + 1)
    return content[:begin] + content[begin : begin + rng.choice((1, 4, 50, 1000))] * 2 + content[begin:]


def _lines(rng, content):
    """Remove, repeat or swap a line."""
    lines = content.splitlines(keepends=True) or [b""]
    one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    way = rng.randrange(3)
    if way == 0:
        del lines[one]
    elif way == 1:
        lines.insert(other, lines[one])
    else:
        lines[one], lines[other] = lines[other], lines[one]
    return b"".join(lines)


def _encode(rng, content):
    text = content.decode(errors="replace")
    return rng.choice((text.encode("utf-16"), text.encode("utf-32"), b"\xef\xbb\xbf" + content, gzip.compress(content)))


def _other_file(rng, _):
    return rng.choice(
        (
            b"",
            b"\n",
            b"\0" * 1000,
            b"PK\x03\x04",
            b"{}",
            b"[]",
            b"null",
            b"<a/>",
            b"PAR1PAR1",
            b"\x89PNG\r\n\x1a\n",
            b"\x7fELF",
        )
    )


def _entities(rng, content):
    """Put entities into XML, that grow by ten at each level or name a file."""
    declared = rng.choice((BOMB, OUTSIDE)).encode()
    content = declared + re.sub(rb"<\?xml[^>]*\?>", b"", content)
    return re.sub(rb'="[^"]*"', rng.choice((b'="&i;"', b'="&a;"')), content, count=rng.choice((1, 5)))


def _declared_encoding(rng, content):
    """Declare an encoding that is unknown, that the parser cannot read, or that the text is not in."""
    name = rng.choice(("UTF9", "rot13", "UTF-32", "utf-7", "utf-16", "latin-1", ""))
    return f'<?xml version="1.0" encoding="{name}"?>'.encode() + re.sub(rb"<\?xml[^>]*\?>", b"", content).lstrip()


BYTES: tuple[Way, ...] = (_flip, _flip, _flip, _truncate, _behead, _cut_out, _repeat, _other_file)
TEXT: tuple[Way, ...] = (
    *(_number, _number, _number, _number, _text, _text, _word, _all_of_a_number, _insert, _deep, _flip, _truncate),
    *(_cut_out, _repeat, _lines, _lines, _encode, _other_file),
)
XML: tuple[Way, ...] = (*TEXT, _entities, _declared_encoding)
