//! Meshes and solids that the tests of this family share, and tests that cross its files.
