//! granary
fn main() {}
