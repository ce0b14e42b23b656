//! From a type to the text of its `.msg` file, with those of all messages in it, as recordings carry them.

use std::collections::BTreeMap;

/// The texts of messages by their names, such as `std_msgs/Header`.
pub type Definitions = BTreeMap<String, String>;

/// What a field of a message can be.
pub trait Field {
    /// As `.msg` files call it.
    fn type_name() -> String;

    /// Adds the texts of the messages in it.
    fn add_to(_: &mut Definitions) {}
}

/// A message of ROS 2.
pub trait Message: Field {
    /// Its name with its package, such as `nav_msgs/msg/Odometry`.
    const NAME: &'static str;

    /// Its text, and after it those of all messages in it, as recordings carry them.
    fn definition() -> String {
        let mut all = Definitions::new();
        Self::add_to(&mut all);
        let own = all.remove(&Self::type_name()).unwrap_or_default();
        let line = "=".repeat(80);
        all.into_iter().fold(own, |text, (name, other)| format!("{text}{line}\nMSG: {name}\n{other}"))
    }
}

macro_rules! primitives {
    ($($rust:ty => $ros:literal;)+) => {
        $(impl Field for $rust {
            fn type_name() -> String {
                $ros.to_string()
            }
        })+
    };
}

primitives! {
    bool => "bool";
    i8 => "int8";
    u8 => "uint8";
    i32 => "int32";
    u32 => "uint32";
    f32 => "float32";
    f64 => "float64";
    String => "string";
    [[f64; 6]; 6] => "float64[36]";
}

impl<T: Field> Field for Vec<T> {
    fn type_name() -> String {
        format!("{}[]", T::type_name())
    }

    fn add_to(all: &mut Definitions) {
        T::add_to(all);
    }
}

/// Messages as types, with the texts of their `.msg` files.
macro_rules! messages {
    ($($(#[$doc:meta])* $package:ident / $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)+ })+) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
            pub struct $name {
                $($(#[$field_doc])* pub $field: $type,)+
            }

            impl $crate::Field for $name {
                // A message may be called `String` itself.
                fn type_name() -> ::std::string::String {
                    concat!(stringify!($package), "/", stringify!($name)).to_string()
                }

                fn add_to(all: &mut $crate::Definitions) {
                    let lines = [$(format!("{} {}\n", <$type as $crate::Field>::type_name(), stringify!($field)),)+];
                    if all.insert(Self::type_name(), lines.concat()).is_none() {
                        $(<$type as $crate::Field>::add_to(all);)+
                    }
                }
            }

            impl $crate::Message for $name {
                const NAME: &'static str = concat!(stringify!($package), "/msg/", stringify!($name));
            }
        )+
    };
}

pub(crate) use messages;
