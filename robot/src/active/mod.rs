//! Active localization: where to drive to learn most about the position.
