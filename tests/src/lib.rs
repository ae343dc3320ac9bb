//! Tests that cross the crates of Breccia live in `tests/`; this library is empty.
