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
    "it'ſ", "a'ſ b'ŝ", "<start_of_text>", "<end_of_text>", "a <START_OF_TEXT> b<end_of_text>c",
    "<start_of_text", "start_of_text>", "<ſtart_of_text>", "|startoftext|", "<|endoftext|>",
    "(╯°□°)╯︵ ┻━┻", "¯\\_(ツ)_/¯", "0", "00", "½ ¼ ² ³ ₄ Ⅷ ⅷ ① ⑳ ༳ ௧", "٣٤٥ १२३ ๔๕",
]
SCRIPTS = [
    "naïve café résumé Ångström", "Straße GROẞE", "ĲSSELMEER ĳs ŉ Ǆ ǅ ǆ Ǉ ǈ Ǌ Ǳ ǲ", "ﬁsh ﬂour eﬀect oﬃce baﬄe ﬅ ﬆ",
    "İstanbul ISTANBUL ıstanbul", "Žluťoučký kůň", "Привет, мир! ЁЖ", "Ελληνικά ΟΔΟΣ ΣΊΣΥΦΟΣ", "ΑΣ ΑΣ. ΑΣΑ Σ", "שלום עולם",
    "مرحبا بالعالم", "سَلَام", "नमस्ते दुनिया", "สวัสดีชาวโลก", "こんにちは世界", "カタカナ ﾊﾝｶｸ ｶﾞｷﾞ", "ＦＵＬＬ　ＷＩＤＴＨ　１２３！", "你好，世界。", "안녕하세요",
    "ᄒᆞᆫ글", "Հայերեն ՈՒ", "ქართული ᲥᲐᲠᲗᲣᲚᲘ", "ᎠᏂᏴᏫᏯ ꭰꮒ", "አማርኛ", "தமிழ்", "বাংলা", "ភាសាខ្មែរ", "𝒜𝓫𝓬 𝟙𝟚𝟛", "𐐀𐐁 𐐨",
    "e\u0301 a\u030a o\u0308\u0323 n\u0303", "A\u0300\u0301\u0302", "\u0301alone", "x\u0345y", "q\u0307\u0323 \u1e9b\u0323",
    "\u212b \u2126 \u212a K'\u212as", "zero\u200bwidth\u200cjoin\u200der", "soft\u00adhyphen", "right\u200fto\u200eleft",
    "nb\u00a0space\u2003em\u2009thin\u3000wide\u1680ogham\u202fnarrow\u205fmath", "line\u2028para\u2029next\u0085end",
    "bom\ufeffinside", "\ufeffbom", "object\ufffcreplace\ufffdment", "bell\x07 esc\x1b[31mred\x1b[0m nul\x00 del\x7f",
    "vt\x0bff\x0cfs\x1cgs\x1d", "c1 \x80\x93\x94 controls", "private \ue000\uf8ff", "unassigned \u0378", "tag \U000e0067",
    "😀", "👩‍👩‍👧‍👦 family", "🇩🇪🇫🇷", "👍🏽 thumbs", "1️⃣ keycap", "❤️ vs ❤", "☕️ and ☂", "🏴\U000e0067\U000e0062\U000e0065\U000e006e\U000e0067\U000e007f",
    "☃️snow❄man", "→ ← ⇒ ∀x∈ℝ: √x ≥ 0", "€100 £5 ¥9 ¢", "№ 5 ™ ® ©", "™®©…–—", "ªº", "ﷺ", "ﬀﬁ\u0301",
]
HTML = [
    "&amp;", "&amp;amp;", "&amp;amp;amp;", "salt &amp; pepper", "salt & pepper", "AT&T", "&lt;b&gt;bold&lt;/b&gt;",
    "caf&eacute; &Eacute;", "P&EACUTE;REZ &NTILDE; &nTILDE;", "BUNDESSTRA&SZLIG;E", "&eacute without semicolon &ampx &copy2024",
    "&notit; &notin; &not;", "&#233; &#xe9; &#XE9;", "&#8217; &#x2019;s", "&#39;s &apos;t &quot;q&quot;", "&#0; &#1; &#128; &#x80;",
    "&#55296; &#xD83D;&#xDE00; &#1114112; &#99999999999999999999;", "&#x1F600;", "&#65534; &#xfdd0;", "&#; &#x; &; &&& &#abc;",
    "&nbsp;&nbsp;a&nbsp;b&ensp;c", "&hellip;&mdash;&ndash;&lsquo;&rsquo;&ldquo;&rdquo;", "&alpha;&Alpha;&ALPHA; &OMEGA; &larr;",
    "<p>&lsquo;tag&rsquo;</p>", "a\n<b>\n&lsquo;c&rsquo;", "&lsquo;a\n<b>\n&lsquo;c&rsquo;", "&amp;eacute; &amp;#233;", "&#38;#233; &#38;eacute;",
    "&LT;&GT;&AMP;&QUOT;&COPY;&REG;&TRADE;", "&lt;start_of_text&gt;", "&unknown; &foo", "&#59; &amp#59;", "&#10;&#13;&#9;|&#12;", "&#11;&#28;|", "x&shy;y&zwj;z",
    "&#x1b;[31mred", "&ltgt &ampamp;", "&frac12; &sup2; &FRAC12;", "&spades;&hearts;", "&lang;x&rang;", "fi&#64257;sh",
]
OVER_LONG = [
    "word " * 74, "word " * 75, "word " * 76, "word " * 400, "x" * 3000, "!" * 500, "1" * 200, "🎉" * 60,
    "the quick brown fox jumps over the lazy dog " * 12, "antidisestablishmentarianism" * 20, "é" * 300, ("a" * 7 + "'s ") * 40,
]
# Texts that our tokenizer knowingly treats differently, with the reason.
DIFFERENT = [
    ("cafÃ© âœ” No problems", "mojibake"), ("voilÃ\u00a0 le travail", "mojibake"), ("itâ€™s", "mojibake"),
    ("&checkmark; &Jscr;ohn", "HTML 5 names"), ("&ltimes;", "HTML 5 names"),
]
# Blocks that have not changed since Unicode 12, so that no library's age matters.
RANGES = [
    (0x20, 0x7E), (0x20, 0x7E), (0x20, 0x7E), (0xA0, 0x24F), (0x300, 0x36F), (0x391, 0x3C9), (0x400, 0x45F), (0x5D0, 0x5EA),
    (0x621, 0x64A), (0x905, 0x939), (0x2000, 0x206F), (0x2190, 0x22FF), (0x2460, 0x24FF), (0x3041, 0x30FE), (0x4E00, 0x9FA5),
    (0xAC00, 0xD7A3), (0xFB00, 0xFB06), (0xFF01, 0xFFEE), (0x1D400, 0x1D6A5), (0x1F600, 0x1F64F), (0x00, 0x1F), (0x7F, 0x9F),
]
PIECES = ["&amp;", "&eacute;", "&#x27;", "'s", "'ll", " ", "  ", "\n", "<", "&", ";", "#", "&lt", "1", "the", "\u0301", "’"]


def is_mojibake(text):
    """Whether ftfy's guessing of character sets changes the text, on the way or at once."""
    import ftfy
    return ftfy.fix_text(text) != ftfy.fix_text(text, fix_encoding=False)


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
        if not is_mojibake(text):
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
    texts = ORDINARY + SCRIPTS + HTML + OVER_LONG + make_random_texts(arguments.random, arguments.seed)
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
