//! Where two states differ: the first part that is not the same, by its path, as
//! `machine.tasks[17].registers[3]`.
//!
//! Both are walked by what is written when they are saved, so every part of a state has a path.

use serde::ser;
use serde::ser::Serialize;
use std::fmt;
use std::fmt::Display;

/// The first part in which two values differ; none if they are written alike.
///
/// Cost: both are written out in full.
pub fn difference<T: Serialize + ?Sized>(name: &str, left: &T, right: &T) -> Option<Difference> {
    let (left, right) = (leaves(name, left), leaves(name, right));
    let length = left.len().max(right.len());
    (0..length).find(|&at| left.get(at) != right.get(at)).map(|at| {
        let path = |leaf: Option<&(String, String)>| leaf.map(|(path, _)| path.clone());
        let found = |leaf: Option<&(String, String)>| leaf.map_or("nothing".to_string(), |(_, value)| value.clone());
        let (left, right) = (left.get(at), right.get(at));
        Difference { path: path(left).or(path(right)).unwrap_or_default(), left: found(left), right: found(right) }
    })
}

/// A part that is not the same in two states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Where it is.
    pub path: String,
    /// What the first state has there.
    pub left: String,
    /// What the second has.
    pub right: String,
}

impl Display for Difference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} is {} in one and {} in the other", self.path, self.left, self.right)
    }
}

fn leaves<T: Serialize + ?Sized>(name: &str, value: &T) -> Vec<(String, String)> {
    let mut walk = DifferenceWalk { path: name.to_string(), leaves: Vec::new(), places: Vec::new() };
    match value.serialize(&mut walk) {
        Ok(()) => walk.leaves,
        Err(error) => unreachable!("a state can be written: {error}"),
    }
}

/// Tables keep their entries in a list of this name, which paths leave out.
const TABLE: &str = "slots";

struct DifferenceWalk {
    path: String,
    leaves: Vec<(String, String)>,
    /// For each list under way: the number of its next element.
    places: Vec<usize>,
}

/// Nothing can go wrong; [`ser::Serializer`] wants a type for it.
#[derive(Debug)]
struct Never(String);

impl Display for Never {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

impl std::error::Error for Never {}

impl ser::Error for Never {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

type Walked = Result<(), Never>;

impl DifferenceWalk {
    fn leaf(&mut self, value: impl Display) -> Walked {
        self.leaves.push((self.path.clone(), value.to_string()));
        Ok(())
    }

    fn below<T: Serialize + ?Sized>(&mut self, step: &str, value: &T) -> Walked {
        let length = self.path.len();
        self.path.push_str(step);
        value.serialize(&mut *self)?;
        self.path.truncate(length);
        Ok(())
    }

    fn element<T: Serialize + ?Sized>(&mut self, value: &T) -> Walked {
        let number = self.places.last_mut().map_or(0, |place| std::mem::replace(place, *place + 1));
        self.below(&format!("[{number}]"), value)
    }

    /// A list begins: its length is a part of it.
    fn list(&mut self, length: Option<usize>) -> Result<&mut Self, Never> {
        self.leaf(format_args!("{} long", length.unwrap_or(0)))?;
        self.places.push(0);
        Ok(self)
    }

    fn listed(&mut self) -> Walked {
        self.places.pop();
        Ok(())
    }
}

macro_rules! leaf {
    ($($name:ident: $kind:ty),*) => {
        $(fn $name(self, value: $kind) -> Walked { self.leaf(value) })*
    };
}

impl<'w> ser::Serializer for &'w mut DifferenceWalk {
    type Ok = ();
    type Error = Never;
    type SerializeSeq = &'w mut DifferenceWalk;
    type SerializeTuple = &'w mut DifferenceWalk;
    type SerializeTupleStruct = &'w mut DifferenceWalk;
    type SerializeTupleVariant = &'w mut DifferenceWalk;
    type SerializeMap = &'w mut DifferenceWalk;
    type SerializeStruct = &'w mut DifferenceWalk;
    type SerializeStructVariant = &'w mut DifferenceWalk;

    leaf!(serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_i128: i128, serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64,
        serialize_u128: u128, serialize_char: char, serialize_unit_struct: &'static str);

    fn serialize_f32(self, value: f32) -> Walked {
        self.serialize_f64(f64::from(value))
    }

    fn serialize_f64(self, value: f64) -> Walked {
        self.leaf(format_args!("{value:?} ({:#x})", value.to_bits()))
    }

    fn serialize_str(self, value: &str) -> Walked {
        self.leaf(format_args!("{value:?}"))
    }

    fn serialize_bytes(self, value: &[u8]) -> Walked {
        self.leaf(format_args!("{value:?}"))
    }

    fn serialize_none(self) -> Walked {
        self.leaf("none")
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Walked {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Walked {
        self.leaf("nothing")
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Walked {
        self.leaf(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Walked {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Walked {
        self.leaf(variant)?;
        self.below(&format!(".{variant}"), value)
    }

    fn serialize_seq(self, length: Option<usize>) -> Result<Self, Never> {
        self.list(length)
    }

    fn serialize_tuple(self, length: usize) -> Result<Self, Never> {
        self.list(Some(length))
    }

    fn serialize_tuple_struct(self, _: &'static str, length: usize) -> Result<Self, Never> {
        self.list(Some(length))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        length: usize,
    ) -> Result<Self, Never> {
        self.leaf(variant)?;
        self.list(Some(length))
    }

    fn serialize_map(self, length: Option<usize>) -> Result<Self, Never> {
        self.list(length)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, Never> {
        Ok(self)
    }

    fn serialize_struct_variant(self, _: &'static str, _: u32, variant: &'static str, _: usize) -> Result<Self, Never> {
        self.leaf(variant)?;
        Ok(self)
    }
}

macro_rules! elements {
    ($($part:ident $method:ident),*) => {
        $(impl ser::$part for &mut DifferenceWalk {
            type Ok = ();
            type Error = Never;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Walked {
                self.element(value)
            }

            fn end(self) -> Walked {
                self.listed()
            }
        })*
    };
}

elements!(SerializeSeq serialize_element, SerializeTuple serialize_element, SerializeTupleStruct serialize_field,
    SerializeTupleVariant serialize_field);

impl ser::SerializeMap for &mut DifferenceWalk {
    type Ok = ();
    type Error = Never;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Walked {
        self.below(".key", key)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Walked {
        self.element(value)
    }

    fn end(self) -> Walked {
        self.listed()
    }
}

macro_rules! fields {
    ($($part:ident),*) => {
        $(impl ser::$part for &mut DifferenceWalk {
            type Ok = ();
            type Error = Never;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Walked {
                if name == TABLE { value.serialize(&mut **self) } else { self.below(&format!(".{name}"), value) }
            }

            fn end(self) -> Walked {
                Ok(())
            }
        })*
    };
}

fields!(SerializeStruct, SerializeStructVariant);
