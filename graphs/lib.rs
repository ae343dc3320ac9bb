//! The presets of Breccia and the exemplars and meshes they use, embedded in the binary.
