"""The small words around a noun in a goal: what is said to a robot, prepositions, adjectives."""

from typing import Final

Phrases = tuple[tuple[str, ...], ...]


def _phrases(text: str) -> Phrases:
    """Commas part phrases; the longest come first, for they begin as shorter ones do."""
    return tuple(sorted((tuple(p.split()) for p in text.split(",")), key=len, reverse=True))


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


THEN: Final = _phrases("""
    after that, afterwards, and after that, and afterwards, and then, danach, dann, daarna, después,
    e poi, en daarna, en dan, ensuite, et ensuite, et puis, luego, poi, puis, then, und danach, und
    dann, y después, y luego
    """)
"""Said before what is to be done next."""
FRONT: Final = (
    *_phrases("""
    alsjeblieft, and, are there, bitte, bring, bring me, bring us, busca, busco, can i, can
    we, can you, can you see, cerca, cerco, cherche, come on, could i, could we, could you,
    dear robot, did you see, do you know, do you know where, do you mind, do you see, donde
    esta, donde estan, dov'è, dove, drive to, dónde está, dónde están, encontre, encuentra,
    fetch, fetch me, find, find me, find us, finde, finde mir, finding, first, get, get me,
    go, go and, go to, goal, grab, guide me to, have you seen, head to, hello, help, help
    me, help me to, help us, hey, hey robot, hi, how about, i am looking for, i am searching
    for, i can not find, i cannot find, i do not find, i do not know where, i forgot, i
    forgot where, i have lost, i have mislaid, i left, i look for, i lost, i misplaced, i
    need, i need to find, i need you to, i put, i want, i want to find, i want you to, i
    would like, i would like to find, i would like to have, i would like you to, ich suche,
    ik zoek, is there, it is, je cherche, just, kindly, lead me to, let us, locate, look,
    look around for, look for, looking for, me, move to, my goal is, navigate to, now,
    object, ok, okay, onde esta, onde está, ou est, ou sont, où est, où sont, per favore,
    pick up, please, por favor, procura, quickly, robot, s'il te plait, s'il vous plait,
    search, search for, search the home for, search the house for, searching for, seek,
    shall we, show, show me, spot, such, suche, take me to, target, tell me, the goal is,
    there are, there is, to, trouve, trouve moi, trova, try to, us, vind, waar is, waar
    zijn, we are looking for, we lost, we need, we want, what about, where are, where could,
    where did i leave, where did i put, where did we leave, where did we put, where have i
    left, where have i put, where is, where might, where on earth are, where on earth is,
    where was, where were, will you, wo ist, wo sind, would you, would you mind, you find,
    zoek
    """),
    (",",), ("no", ","), ("yes", ","), ("well", ","),
)  # fmt: skip
"""Said before what is looked for, to whoever is to look."""
BACK: Final = (
    *_phrases("""
    again, alsjeblieft, anywhere, are, are they, around here, as well, at once, be, bitte,
    can you, could you, danke, fast, first, for me, for me please, for us, gracias, here, if
    possible, if you can, if you please, immediately, is, is it, it, kindly, many thanks,
    merci, nearby, now, per favore, please, por favor, quickly, right now, robot, s'il te
    plait, s'il vous plait, somewhere, somewhere here, thank you, thank you very much,
    thanks, thanks a lot, today, too, was, will you, would you
    """),
    (",",),
)  # fmt: skip
"""Said behind it."""
CONTRACTED: Final = {
    "where's": ("where", "is"),
    "wheres": ("where", "is"),
    "where're": ("where", "are"),
    "i'm": ("i", "am"),
    "i'd": ("i", "would"),
    "i've": ("i", "have"),
    "we're": ("we", "are"),
    "can't": ("cannot",),
    "cant": ("cannot",),
    "let's": ("let", "us"),
    "don't": ("do", "not"),
    "dont": ("do", "not"),
    "isn't": ("is", "not"),
    "aren't": ("are", "not"),
    "there's": ("there", "is"),
    "that's": ("that", "is"),
    "it's": ("it", "is"),
    "pls": ("please",),
    "plz": ("please",),
    "thx": ("thanks",),
}

NOT: Final = (
    *_phrases("""
    and definitely not, and no, and not, apart from, but definitely not, but no, but not,
    certainly not, definitely not, except, except for, instead of, nor, not, or not, other
    than, rather than, really not
    """),
    (",", "no"), (",", "not"),
)  # fmt: skip
"""Behind one of them stands what is not meant."""
OTHER: Final = _phrases("""
    all but, all except, anything but, anything except, do not, everything but, everything
    except, no more, nothing but
""")
"""Before one of them nothing is said that is meant."""
PLACING: Final = _phrases("""
    above, across from, against, along, amid, among, around, at, at the back of, at the
    bottom of, at the end of, at the foot of, at the side of, at the top of, behind, below,
    beneath, beside, besides, between, beyond, by, close to, from, hanging from, hanging
    over, in, in front of, in the back of, in the corner of, in the middle of, inside,
    inside of, into, leaning on, left of, near, near to, next to, off, on, on the edge of,
    on the left of, on the right of, on the side of, on top of, onto, opposite, outside,
    outside of, over, past, right of, to the left of, to the right of, towards, under,
    underneath, upon, within
""")
"""Behind one of them stands a place."""
SAYING: Final = _phrases("""
    about, as, because, covered with, filled with, for, full of, if, like, made from, made
    of, so that, such as, that, to, when, where, which, who, whose, with, without
""")
"""Behind one of them stands what else is said."""

JOINS: Final = frozenset({"and", "or", ",", "then", "plus", "also", "followed"})
BEING: Final = _words("""
    and are be been being but directly down had hanging hangs has have he here hidden i is
    it just kept laid leaning left lies located lying maybe not or out over perhaps placed
    possibly probably put right she sits sitting somewhere standing stands stored that then
    there they up usually was we were which who you
""")
"""Said between a thing and the place that it is in."""
DETERMINERS: Final = _words("""
    a all an another any both each every her his its mine my of one our some that the their
    these this those your
""")
NUMBERS: Final = _words("""
    closest dozen eight farthest few first five four last many more most nearest next nine
    other second seven several six ten third three two
""")
MEASURES: Final = _words("""
    any bit bunch couple each heap kind lot lots number one pair pairs piece pieces pile
    plenty set sets some sort stack type
""")
"""Before "of" it is not they that are looked for."""
LIKE: Final = {
    "little": "small",
    "tiny": "small",
    "compact": "small",
    "big": "large",
    "huge": "big",
    "circular": "round",
    "wood": "wooden",
    "cosy": "comfy",
    "comfortable": "comfy",
}
"""Adjectives that a name of a thing may have in another word's place."""
ADJECTIVES: Final = _words("""
    ancient antique bad beautiful beige big bit black blue bluish bright broken brown
    ceramic cheap checked circular clean clear closed cold colored colorful coloured
    colourful comfortable comfy compact cosy cozy cream cute cyan dark dark-blue dark-green
    deep dirty dotted dry empty enormous expensive fancy favorite favourite flat forgotten
    full full-size giant gold golden good gray green greenish grey grosse grosser grosses
    half-size hard heavy high hot huge kleine kleiner kleines knitted large leather left
    light-blue light-green little long lost lovely low lower magenta maroon massive matt
    medium medium-sized metal metallic missing modern multicoloured narrow navy new nice old
    open orange oval own pale patterned pink plain plastic portable pretty purple quite
    rather really rectangular red reddish right rote roten roter rotes round same shallow
    shiny short silver slightly slim small so soft spare spotted square stainless steel
    striped tall teal thick thin tiny too transparent triangular turquoise ugly upper used
    usual very vintage violet warm wet white whole wide wooden woolen woollen yellow
""")
