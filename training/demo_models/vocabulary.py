# SPDX-License-Identifier: BSD-3-Clause
"""The words that the demo models know, and which words are true of which thing.

Colours and phrases of things are those of the simulation's catalogue. A sentence is a noun phrase
in a frame ("get the red mug"); what it is true of follows from the noun phrase alone.
"""
import random
from dataclasses import dataclass
from typing import FrozenSet, Optional

# Never trained on, in no loss of either network: to measure whether colour and object are understood
# apart from each other.
HELD_OUT_PAIRS = frozenset({
    ("red", "coffee mug"), ("blue", "sofa"), ("green", "bottle"), ("yellow", "book"),
    ("orange", "backpack"), ("purple", "kettle"), ("grey", "armchair"), ("turquoise", "rug"),
    ("brown", "office chair"), ("beige", "waste bin"), ("red", "vase with flowers"),
    ("blue", "alarm clock"), ("green", "toy box"), ("yellow", "soap dispenser"),
    ("purple", "pair of shoes"), ("orange", "folded towels"), ("turquoise", "bed"),
    ("walnut", "desk"), ("white", "wardrobe"), ("birch", "dining table"), ("red", "floor lamp"),
    ("green", "magazine")})

# Colour names of the catalogue that a viewer can tell from the thing itself.
PAINTS = ("red", "blue", "green", "yellow", "orange", "purple", "grey", "beige", "turquoise", "brown")
COLORS = PAINTS + ("oak", "walnut", "birch", "white", "black", "silver", "steel")
# Their catalogue colour is not what one sees first, or the same for all.
COLORLESS = frozenset({"umbrella", "toothbrush", "laundry basket", "picture", "coat rack"})

SYNONYMS = {
    "coffee mug": ("mug", "cup"), "sofa": ("couch",), "refrigerator": ("fridge",),
    "television": ("tv",), "waste bin": ("bin", "trash can"), "potted plant": ("plant",),
    "wash basin": ("basin",), "microwave oven": ("microwave",), "pair of shoes": ("shoes",),
    "row of books": ("books",), "computer monitor": ("monitor", "screen"), "football": ("ball",),
    "folded towels": ("towels",), "alarm clock": ("clock",), "vase with flowers": ("vase", "flowers"),
    "bowl of fruit": ("fruit bowl", "fruit"), "cardboard box": ("carton",), "toy blocks": ("blocks",),
    "frying pan": ("pan",), "soap dispenser": ("soap",), "rug": ("carpet",), "wardrobe": ("closet",),
    "stove": ("cooker", "oven"), "vacuum cleaner": ("hoover",), "picture": ("painting",),
    "front door": ("door",), "bathtub": ("bath tub",), "remote control": ("remote",),
    "nightstand": ("bedside table",), "teddy bear": ("teddy",), "chest of drawers": ("dresser",)}

# Words for several kinds of things.
GROUPS = {
    "something to read": ("book", "magazine"), "something to sit on": (
        "sofa", "armchair", "dining chair", "office chair"),
    "chair": ("armchair", "dining chair", "office chair"), "seat": (
        "sofa", "armchair", "dining chair", "office chair"),
    "table": ("dining table", "coffee table"), "lamp": (
        "floor lamp", "desk lamp", "bedside lamp", "ceiling lamp"),
    "toy": ("teddy bear", "toy blocks", "football"), "something to drink from": ("coffee mug",),
    "shelf": ("bookshelf", "storage shelf"), "cabinet": (
        "kitchen cabinet", "wall cabinet", "filing cabinet")}

ROOMS = ("corridor", "living room", "kitchen", "bedroom", "bathroom", "office", "children's room",
         "storage room")
ROOM_SYNONYMS = {"corridor": ("hallway",), "office": ("study",), "bathroom": ("restroom",),
                 "children's room": ("nursery", "childrens room"), "storage room": ("storeroom",)}
ROOM_FRAMES = ("{}", "the {}", "a {}", "an image of a {}", "go to the {}", "clean the {}",
               "a photo of the {}", "where is the {}", "tidy the {}", "paint the {}")

OBJECT_FRAMES = (
    "{}", "{}", "a {}", "the {}", "an image of {}", "an image of a {}", "a photo of a {}",
    "get the {}", "get a {}", "bring the {}", "bring me the {}", "take the {}", "take a {}",
    "fetch the {}", "find the {}", "find {}", "find a {}", "clean the {}", "open the {}",
    "close the {}", "move the {}", "switch on the {}", "turn off the {}", "empty the {}",
    "load the {}", "make the {}", "water the {}", "tidy the {}", "set the {}", "sit on the {}",
    "use the {}", "look at the {}", "wash the {}", "put away the {}", "pick up the {}",
    "hand me the {}", "repair the {}", "play the {}", "show me the {}", "where is the {}",
    "go to the {}", "read the {}", "carry the {}", "inspect the {}", "check the {}", "fill the {}",
    "put something on the {}", "give me a {}", "play with the {}", "fold the {}", "fix the {}",
    "dust the {}", "i need the {}", "i want a {}", "please bring me the {}")

# Things that no apartment has: texts that no image fits.
ABSENT = (
    "bicycle", "piano", "guitar", "car", "dog", "cat", "horse", "tree", "boat", "airplane", "drum",
    "hammer", "ladder", "camera", "violin", "trumpet", "motorcycle", "truck", "bus", "bird", "fish",
    "pizza", "burger", "cake", "banana", "sandwich", "scissors", "phone", "wallet", "keys", "glasses",
    "helmet", "skateboard", "tent", "fire extinguisher", "traffic light", "statue", "fountain",
    "elevator", "robot", "person", "baby", "fireplace", "aquarium", "candle", "suitcase", "hat",
    "swimming pool", "garage", "garden", "fridge magnet", "engine", "wheelchair", "treadmill")


UNKNOWN = "qqq"  # stands for a word that is in no sentence


@dataclass(frozen=True)
class Text:
    """A sentence and what it is true of; None = any."""
    sentence: str
    classes: Optional[FrozenSet] = None
    color: Optional[str] = None
    rooms: Optional[FrozenSet] = None  # set: about rooms, true of no thing
    absent: bool = False  # true of nothing


def color_of(phrase, color):
    """The colour's name, or None if a viewer could not name it."""
    return None if phrase in COLORLESS or color not in COLORS else color


def is_held_out(phrase, color):
    return (color, phrase) in HELD_OUT_PAIRS


def draw_frame(rng: random.Random, frames):
    """Now and then with a word that nobody knows, which is to change nothing."""
    frame = rng.choice(frames)
    return f"{UNKNOWN} {frame}" if rng.random() < 0.06 else frame


def describe_thing(rng: random.Random, phrase, color):
    """A random sentence that is true of a thing."""
    color = color_of(phrase, color)
    frame = draw_frame(rng, OBJECT_FRAMES)
    classes = frozenset({phrase})
    kind = rng.random()
    if color is not None and kind < 0.08:
        return Text(frame.format(f"{color} {rng.choice(('thing', 'object', 'one'))}"), None, color)
    if kind < 0.16:
        groups = [name for name, members in GROUPS.items() if phrase in members]
        if groups:
            name = rng.choice(groups)
            named = color if color is not None and kind < 0.10 else None
            noun = f"{named} {name}" if named and not name.startswith("something") else name
            named = None if noun == name else named
            return Text(frame.format(noun), frozenset(GROUPS[name]), named)
    names = (phrase,) * 3 + SYNONYMS.get(phrase, ())
    noun = rng.choice(names)
    if color is None or kind < 0.58:
        return Text(frame.format(noun), classes)
    return Text(frame.format(f"{color} {noun}"), classes, color)


def describe_apart(rng: random.Random, phrase, color):
    """Sentences that teach colour and kind apart from each other: a random one, its colour alone, and
    one of the same kind in another colour."""
    texts = [describe_thing(rng, phrase, color)]
    named = color_of(phrase, color)
    if named is None:
        return texts
    if rng.random() < 0.5:
        noun = rng.choice(("thing", "object", "one"))
        texts.append(Text(draw_frame(rng, OBJECT_FRAMES).format(f"{named} {noun}"), None, named))
    other = rng.choice(COLORS)
    if not is_held_out(phrase, other):
        noun = rng.choice((phrase,) * 3 + SYNONYMS.get(phrase, ()))
        texts.append(Text(draw_frame(rng, OBJECT_FRAMES).format(f"{other} {noun}"),
                          frozenset({phrase}), other))
    return texts


def describe_room(rng: random.Random, room):
    name = rng.choice((room,) * 3 + ROOM_SYNONYMS.get(room, ()))
    return Text(draw_frame(rng, ROOM_FRAMES).format(name), rooms=frozenset({room}))


def describe_nothing(rng: random.Random):
    """A sentence that no image fits: a thing that no apartment has, or a word never seen."""
    noun = rng.choice(ABSENT) if rng.random() < 0.7 else UNKNOWN
    if rng.random() < 0.2:
        noun = f"{rng.choice(COLORS)} {noun}"
    return Text(rng.choice(OBJECT_FRAMES).format(noun), absent=True)


def list_phrases(things):
    """Names of colour-object pairs, e.g. "red coffee mug", of an iterable of (phrase, colour)."""
    return sorted({f"{c} {p}" for p, c in things if color_of(p, c) is not None})


def list_sentences():
    """Sentences that together hold every word that may be trained on, apart from the classes'."""
    nouns = list(SYNONYMS) + [s for names in SYNONYMS.values() for s in names] + list(GROUPS)
    nouns += list(ABSENT) + list(ROOMS) + [s for names in ROOM_SYNONYMS.values() for s in names]
    nouns += list(COLORS) + ["thing", "object", "one"]
    frames = [f.format("").strip() for f in OBJECT_FRAMES + ROOM_FRAMES]
    return nouns + [f for f in frames if f]
