//! Words to phrases.
//!
//! ```text
//! text     = { "then" } { phrase { "then" } }                  "then" is also "and", a comma, a full stop
//! phrase   = leave | foyer | end | opening | straight | enter
//! leave    = ( LEAVE | [ GO ] OUT ) [ room ] [ [ "then" ] [ TURN | GO ] side ]
//!          | ( TURN | GO ) side [ AFTER ] ( LEAVE | OUT ) [ room ]
//! foyer    = { GO } { straight } [ hallway ] [ UNTIL ] ( PAST | AFTER | THROUGH | PASS ) foyer
//! end      = { GO } { straight } [ hallway ] [ UNTIL ] [ REACH ] [ hallway ] end [ hallway ]
//! opening  = [ verb ] mention [ AFTER foyer | end [ hallway ] ] [ IS room ]
//! verb     = [ room ] IS [ room ] [ IN | AFTER ] | ENTER | [ GO ] ( IN | THROUGH )
//!          | TURN [ IN ] | GO { straight } | [ GO ] { straight } [ hallway ] UNTIL [ REACH ]
//! mention  = side [ "then" | IN ] ordinal [ noun ] | noun ordinal side
//!          | ordinal [ noun ] side [ noun ] | [ noun ] side [ noun ] | ordinal [ noun ]
//! straight = GO { straight } [ hallway ]
//! enter    = ENTER [ room ]
//! ```
//!
//! A noun is a door, a room, a hallway, or an opening of unknown kind. Words that carry nothing ("the",
//! "on", "please") are not there any more.

use super::words::Word;
use crate::feature::Side;
use chumsky::input::MappedInput;
use chumsky::prelude::*;

/// One thing that is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phrase {
    /// To leave the room one is in, to a side if it is said.
    Leave(Option<Side>),
    /// To pass a foyer.
    Foyer,
    /// To go to the end of the hallway.
    End,
    /// To go to an opening.
    Opening { verb: Verb, mention: Mention, place: Place },
    /// To go on, which the robot does anyway.
    Straight,
    /// To enter what was spoken of before.
    Enter,
    /// No phrase; whether a word of it is none, which was told.
    Lost { told: bool },
}

/// What is to be done at an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verb {
    Unsaid,
    Turn,
    Enter,
}

/// An opening as it is spoken of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mention {
    pub ordinal: Option<u8>,
    pub side: Option<Side>,
    pub noun: Option<Noun>,
}

/// What an opening is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Noun {
    Door,
    Hallway,
    Opening,
}

/// Where an opening is said to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    InHallway,
    AfterFoyer,
    AtEnd,
}

type Words<'t> = MappedInput<'t, Word, SimpleSpan, &'t [(Word, SimpleSpan)]>;

/// What reads a phrase or a large part of one. Its own type, made of all its parts, ends here: the compiler would
/// compile it anew wherever it is a part.
type Reader<'t, T> = Boxed<'t, 't, Words<'t>, T>;

/// The phrases of a text with their places; what is none, up to the next "then", is `Lost`. Cost: linear,
/// because no phrase is longer than some words.
pub(super) fn phrases(words: &[(Word, SimpleSpan)], text_len: usize) -> Vec<(Phrase, SimpleSpan)> {
    let end = SimpleSpan::from(text_len..text_len);
    text().parse(words.split_token_span(end)).into_output().unwrap_or_default()
}

fn text<'t>() -> impl Parser<'t, Words<'t>, Vec<(Phrase, SimpleSpan)>> {
    let then = just(Word::Then).repeated();
    let lost = none_of(Word::Then)
        .map(|word| word == Word::Unknown)
        .foldl(none_of(Word::Then).map(|word| word == Word::Unknown).repeated(), |told, unknown| told || unknown);
    let lost = lost.map(|told| Phrase::Lost { told });
    let phrase = choice((leave(), foyer(), end_of_hallway(), opening(), straight(), enter(), lost));
    let placed = phrase.map_with(|phrase, e| (phrase, e.span()));
    then.ignore_then(placed.then_ignore(just(Word::Then).repeated()).repeated().collect())
}

fn side<'t>() -> impl Parser<'t, Words<'t>, Side> + Clone {
    select_ref! { Word::Side(side) => *side }
}

fn ordinal<'t>() -> impl Parser<'t, Words<'t>, u8> + Clone {
    select_ref! { Word::Ordinal(ordinal) => *ordinal, Word::Next => 1 }
}

fn noun<'t>() -> impl Parser<'t, Words<'t>, Noun> + Clone {
    let noun = select_ref! {
        Word::Door => Noun::Door,
        Word::Room => Noun::Door,
        Word::Hallway => Noun::Hallway,
        Word::Opening => Noun::Opening,
    };
    noun.then_ignore(just(Word::End).not())
}

fn word<'t>(word: Word) -> impl Parser<'t, Words<'t>, ()> + Clone {
    just(word).ignored()
}

fn maybe<'t>(known: Word) -> impl Parser<'t, Words<'t>, ()> + Clone {
    just(known).or_not().ignored()
}

/// `[ GO ] { straight } [ hallway ]`
fn on_the_way<'t>() -> impl Parser<'t, Words<'t>, ()> + Clone {
    just(Word::Go).repeated().then(just(Word::Straight).repeated()).then(maybe(Word::Hallway)).ignored()
}

fn leave<'t>() -> Reader<'t, Phrase> {
    let going = choice((word(Word::Turn), word(Word::Go)));
    let out = choice((word(Word::Leave), maybe(Word::Go).then_ignore(just(Word::Out)))).then_ignore(maybe(Word::Room));
    let into_hallway = just(Word::In).then(just(Word::Hallway)).or_not();
    let to_side = side().then_ignore(into_hallway).then_ignore(choice((ordinal().ignored(), noun().ignored())).not());
    let and_go = maybe(Word::Then).then(going.clone().then(just(Word::Straight).repeated()).or_not());
    let tail = and_go.ignore_then(to_side).or_not();
    let side_first = going.ignore_then(side()).then_ignore(maybe(Word::After)).then_ignore(out.clone());
    choice((out.ignore_then(tail).map(Phrase::Leave), side_first.map(|side| Phrase::Leave(Some(side))))).boxed()
}

fn foyer<'t>() -> Reader<'t, Phrase> {
    let past = one_of([Word::Past, Word::After, Word::Through, Word::Pass]).repeated().at_least(1);
    on_the_way().then(maybe(Word::Until)).then(past).then(just(Word::Foyer)).to(Phrase::Foyer).boxed()
}

fn end_of_hallway<'t>() -> Reader<'t, Phrase> {
    let until = maybe(Word::Until).then(maybe(Word::Reach)).then(maybe(Word::Hallway));
    on_the_way().then(until).then(the_end()).to(Phrase::End).boxed()
}

fn the_end<'t>() -> impl Parser<'t, Words<'t>, ()> + Clone {
    just(Word::End).then(maybe(Word::Hallway)).ignored()
}

fn opening<'t>() -> Reader<'t, Phrase> {
    let place = choice((
        one_of([Word::After, Word::Past]).then(just(Word::Foyer)).to(Place::AfterFoyer),
        the_end().to(Place::AtEnd),
        empty().to(Place::InHallway),
    ));
    let is_room = just(Word::Is).then(just(Word::Room)).or_not();
    let phrase = verb().then(mention()).then(place).then(is_room);
    let phrase = phrase.map(|(((verb, mention), place), is_room)| {
        let verb = if is_room.is_some() { Verb::Enter } else { verb };
        Phrase::Opening { verb, mention, place }
    });
    phrase.boxed()
}

fn verb<'t>() -> Reader<'t, Verb> {
    let room = || maybe(Word::Room);
    let is = room().then(just(Word::Is)).then(room()).then(one_of([Word::In, Word::After]).or_not());
    let into = maybe(Word::Go).then(just(Word::Straight).repeated()).then(one_of([Word::In, Word::Through]));
    let turn = just(Word::Turn).then(just(Word::Straight).repeated()).then(maybe(Word::In));
    let until = on_the_way().then(just(Word::Until)).then(maybe(Word::Reach)).ignored();
    let to = maybe(Word::Go).then(just(Word::Straight).repeated()).ignored();
    choice((
        is.to(Verb::Enter),
        just(Word::Enter).to(Verb::Enter),
        into.to(Verb::Enter),
        turn.to(Verb::Turn),
        until.to(Verb::Unsaid),
        to.to(Verb::Unsaid),
    ))
    .boxed()
}

fn mention<'t>() -> Reader<'t, Mention> {
    let of = |(ordinal, side, noun)| Mention { ordinal, side, noun };
    let some_side = || side().map(Some);
    let counted = || ordinal().map(Some);
    // "on the right, the second door", but not "left, second right".
    let between = one_of([Word::Then, Word::In]).or_not();
    let side_first = some_side().then_ignore(between).then(counted()).then(noun().or_not());
    let side_first = side_first.then_ignore(side().not());
    let numbered = noun().map(Some).then(counted()).then(some_side());
    let plain = counted().then(noun().or_not()).then(some_side()).then(noun().or_not());
    let uncounted = noun().or_not().then(some_side()).then(noun().or_not()).then_ignore(side().not());
    let sideless = counted().then(noun().or_not()).then_ignore(just(Word::Unknown).not());
    choice((
        side_first.map(move |((side, ordinal), noun)| of((ordinal, side, noun))),
        numbered.map(move |((noun, ordinal), side)| of((ordinal, side, noun))),
        plain.map(move |(((ordinal, before), side), after)| of((ordinal, side, before.or(after)))),
        uncounted.map(move |((before, side), after)| of((None, side, before.or(after)))),
        sideless.map(move |(ordinal, noun)| of((ordinal, None, noun))),
    ))
    .boxed()
}

fn straight<'t>() -> Reader<'t, Phrase> {
    let ahead = just(Word::Straight).repeated().at_least(1).then(maybe(Word::Hallway)).ignored();
    choice((maybe(Word::Go).ignore_then(ahead), just(Word::Go).then(just(Word::Hallway)).ignored()))
        .to(Phrase::Straight)
        .boxed()
}

fn enter<'t>() -> Reader<'t, Phrase> {
    just(Word::Enter).then(maybe(Word::Room)).to(Phrase::Enter).boxed()
}
