#!/usr/bin/env python3
"""Records the token ids that open_clip gives to hard strings, for the tests of the tokenizer.

usage: record_tokens.py [--random N] [--output FILE]
Needs open_clip (pip install open_clip_torch). Without arguments it regenerates
test/unit/language/tokens.json.
"""
import argparse
import importlib.metadata
import json
import pathlib
import platform
import random

OUTPUT = pathlib.Path(__file__).resolve().parents[1] / "unit" / "language" / "tokens.json"

ORDINARY = [
    "", " ", "\t \n\r\n ", "a", "A photo of a CAT.", "an image of a red mug", "wash the dishes",
    "get my   notes\tand\nbooks", "something to sit on while reading", "cook a 2-egg omelette",
    "the dog's bowl", "I'm, you're, he'll, they've, she'd, can't, it's", "IT'S THE CAT'S",
    "rock'n'roll 'tis 'twas", "''''s 's's", "don''t", "state-of-the-art", "x" * 40, "supercalifragilistic",
    "floccinaucinihilipilification", "1234567890", "3.14159", "10,000.50 $ + 7% = ?", "route66 b2b 4x4",
    "ISO-8859-1", "C++17 & C#", "!!!???...", "?!?!?!", "-----", "* * *", "<>", "a<b>c", "(parens) [brackets] {braces}",
    "#hashtag @mention", "https://example.org/a?b=c&d=e#f", "mail@example.org", "a_b__c", "\\back\\slash\\",
    "`code` ~tilde~ ^caret^ |pipe|", "\"quoted\"", "“curly” ‘quotes’ it’s", "‚low‛ „double‟", "5′ 6″", "…", "a–b—c",
    "hello,world;foo:bar", "end.", " leading", "trailing ", "!'s", "..'re", "'S 'T 'RE 'VE 'M 'LL 'D",
    "b'ŝ", "<start_of_text>", "<end_of_text>", "a <START_OF_TEXT> b<end_of_text>c",
    "<start_of_text", "start_of_text>", "|startoftext|", "<|endoftext|>",
    "(╯°□°)╯︵ ┻━┻", "¯\\_(ツ)_/¯", "0", "00", "½ ¼ ² ³ ₄",
]
SCRIPTS = [
    "naïve café résumé Ångström", "Straße GROẞE", "Žluťoučký kůň", "Привет, мир! ЁЖ", "ελληνικά", "שלום עולם",
    "مرحبا بالعالم", "こんにちは世界", "안녕하세요", "Հայերեն ՈՒ", "ქართული ᲥᲐᲠᲗᲣᲚᲘ", "አማርኛ", "𐐀𐐁 𐐨", "\u0301alone",
    "nb\u00a0space\u2003em\u2009thin\u3000wide\u1680ogham\u202fnarrow\u205fmath", "zero\u200bwidth\u200cjoin\u200der",
    "soft\u00adhyphen", "private \ue000\uf8ff", "😀", "👩‍👩‍👧‍👦 family", "🇩🇪🇫🇷", "👍🏽 thumbs", "1️⃣ keycap", "❤️ vs ❤",
    "☕️ and ☂", "☃️snow❄man", "→ ← ⇒ ∀x∈ℝ: √x ≥ 0", "€100 £5 ¥9 ¢", "№ 5 ™ ® ©", "™®©…–—", "ªº",
    "salt & pepper", "AT&T", "&; &&& a&b",
]
OVER_LONG = [
    "word " * 74, "word " * 75, "word " * 76, "word " * 400, "x" * 3000, "!" * 500, "1" * 200, "🎉" * 60,
    "the quick brown fox jumps over the lazy dog " * 12, "antidisestablishmentarianism" * 20, "é" * 300, ("a" * 7 + "'s ") * 40,
]
# Texts that our tokenizer knowingly treats differently, with the reason.
DIFFERENT = [
    ("salt &amp; pepper", "HTML reference"), ("caf&eacute;", "HTML reference"), ("itâ€™s", "mojibake"),
    ("cafe\u0301", "composed accent"), ("ﬁsh", "ligature"), ("ＦＵＬＬ", "width"), ("bell\x07", "control character"),
    ("٣٤٥", "digits of another script"), ("สวัสดี", "letters of another script"), ("ΟΔΟΣ", "last sigma"),
    ("it'ſ", "long s"),
]
# What people type, and blocks that have not changed since Unicode 12, so that no library's age matters.
RANGES = [
    (0x20, 0x7E), (0x20, 0x7E), (0x20, 0x7E), (0xC0, 0x130), (0x134, 0x148), (0x14A, 0x17E), (0x391, 0x3A1),
    (0x3B1, 0x3C9), (0x400, 0x45F), (0x5D0, 0x5EA), (0x2010, 0x2023), (0x2190, 0x22FF), (0x4E00, 0x9FA5),
    (0xAC00, 0xD7A3), (0x1F600, 0x1F64F),
]
PIECES = ["'s", "'ll", " ", "  ", "\n", "<", "&", ";", "#", "1", "the", "’", "“"]


def is_damaged(text):
    """Whether more than quotation marks and line ends of the text would be repaired."""
    import html
    import ftfy
    repaired = html.unescape(html.unescape(ftfy.fix_text(text)))
    return repaired != ftfy.fixes.uncurl_quotes(ftfy.fixes.fix_line_breaks(text))


def make_random_texts(count, seed=1):
    generator = random.Random(seed)
    texts = []
    while len(texts) < count:
        text = ""
        for _ in range(generator.randint(1, 24)):
            if generator.random() < 0.3:
                text += generator.choice(PIECES)
            else:
                text += chr(generator.randint(*generator.choice(RANGES)))
        if not is_damaged(text):
            texts.append(text)
    return texts


def record(text, difference=None):
    import open_clip
    row = open_clip.tokenize([text])[0].tolist()
    while row[-1] == 0 and row[-2] != 49406:
        row.pop()
    entry = {"text": text, "tokens": row}
    if difference:
        entry["differs"] = difference
    return entry


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=150, metavar="N", help="number of random texts")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=pathlib.Path, default=OUTPUT)
    arguments = parser.parse_args()
    texts = ORDINARY + SCRIPTS + OVER_LONG + make_random_texts(arguments.random, arguments.seed)
    entries = [record(text) for text in texts] + [record(*pair) for pair in DIFFERENT]
    versions = {name: importlib.metadata.version(name) for name in ("open_clip_torch", "ftfy", "regex")}
    versions["python"] = platform.python_version()
    with open(arguments.output, "w", encoding="ascii") as out:
        out.write('{"recorded_with": %s,\n "texts": [\n' % json.dumps(versions))
        out.write(",\n".join("  " + json.dumps(entry, separators=(",", ":")) for entry in entries))
        out.write("\n]}\n")
    print("%d texts recorded in %s" % (len(entries), arguments.output))


if __name__ == "__main__":
    main()
