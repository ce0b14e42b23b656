//! What is attacked, whatever it is.

use crate::generated::Dice;

/// Which attack it was; or what must not be.
pub type Judged = Result<&'static str, String>;

/// Something that is attacked.
pub trait Surface {
    /// One attack.
    ///
    /// # Errors
    /// What must not be.
    fn attack(&mut self, dice: &mut Dice) -> Judged;

    /// The end of what was started.
    ///
    /// # Errors
    /// What must not be.
    fn end(&mut self) -> Result<(), String>;
}
