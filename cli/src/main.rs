//! The `breccia` command.

fn main() {}
