//! Placeholder for the workspace member.
