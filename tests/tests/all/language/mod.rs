//! What texts say: values, names, definitions, plans as data, tests in plans.

mod definitions;
mod deftest;
mod evaluation;
mod kinds;
mod plans_as_data;
mod registers;
mod revision;
mod values;
