//! A text as a message. It has a file of its own because it is called as the type of its only field.

use crate::definition::messages;
use std::string::String as Text;

messages! {
    /// A text.
    std_msgs/String {
        /// The text.
        data: Text,
    }
}
