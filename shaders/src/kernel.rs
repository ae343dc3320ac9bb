//! What a kernel says of itself.

/// How a kernel uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// A small block of numbers, the same for all threads.
    Uniform,
    /// Some kilobytes of numbers that all threads read alike.
    Constant,
    /// Read only.
    Read,
    /// Read and written.
    Write,
}

/// One buffer of a kernel; its number is its place in [`Kernel::bindings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The variable in the shader.
    pub name: &'static str,
    /// What the kernel does with it.
    pub access: Access,
}

impl Binding {
    /// A uniform block.
    pub const fn uniform(name: &'static str) -> Self {
        Self { name, access: Access::Uniform }
    }

    /// A buffer of constants.
    pub const fn constant(name: &'static str) -> Self {
        Self { name, access: Access::Constant }
    }

    /// A buffer that is read.
    pub const fn read(name: &'static str) -> Self {
        Self { name, access: Access::Read }
    }

    /// A buffer that is written.
    pub const fn write(name: &'static str) -> Self {
        Self { name, access: Access::Write }
    }
}

/// A compute shader with one entry point, `main`.
#[derive(Debug)]
pub struct Kernel {
    /// The name of its file in `kernels/`, without the extension.
    pub name: &'static str,
    /// The function on the CPU that it mirrors, or what it does if there is none.
    pub mirrors: &'static str,
    /// Its text.
    pub source: &'static str,
    /// Threads of a workgroup.
    pub workgroup: u32,
    /// Its buffers, in the order of their numbers in group 0.
    pub bindings: &'static [Binding],
}
