//! From a kernel's text to a module of naga, with what it imports.

use naga::{AddressSpace, StorageAccess};
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor};

use crate::kernel::{Access, Binding, Kernel};
use crate::kernels::MODULES;

/// A kernel with its imports, as one module.
pub struct Composed {
    /// The module.
    pub module: naga::Module,
}

/// Composes a kernel from its text, or another one that takes its place.
///
/// # Errors
/// What the compiler says, with the place.
pub fn compose(kernel: &Kernel, text: &str) -> Result<Composed, String> {
    // The composer leaves the checking to whoever takes the module.
    let mut composer = Composer::non_validating();
    for &(path, source) in MODULES {
        let module = ComposableModuleDescriptor { source, file_path: path, ..Default::default() };
        if let Err(error) = composer.add_composable_module(module) {
            return Err(error.emit_to_string(&composer));
        }
    }
    let descriptor = NagaModuleDescriptor { source: text, file_path: kernel.name, ..Default::default() };
    match composer.make_naga_module(descriptor) {
        Ok(module) => Ok(Composed { module }),
        Err(error) => Err(error.emit_to_string(&composer)),
    }
}

impl Composed {
    /// The buffers that the module declares, by number; `None` where it skips one.
    pub fn bindings(&self) -> Vec<Option<(String, Access)>> {
        let mut found = Vec::new();
        for (_, variable) in self.module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            let access = match variable.space {
                AddressSpace::Uniform if binding.binding == 0 => Access::Uniform,
                AddressSpace::Uniform => Access::Constant,
                AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Access::Write,
                _ => Access::Read,
            };
            let at = binding.binding as usize;
            if found.len() <= at {
                found.resize(at + 1, None);
            }
            found[at] = Some((variable.name.clone().unwrap_or_default(), access));
        }
        found
    }

    /// Whether the module is as the kernel says; if not, what differs.
    ///
    /// # Errors
    /// The first difference in words.
    pub fn agrees_with(&self, kernel: &Kernel) -> Result<(), String> {
        let expected: Vec<_> =
            kernel.bindings.iter().map(|&Binding { name, access }| Some((name.to_owned(), access))).collect();
        let found = self.bindings();
        if found != expected {
            return Err(format!("`{}` binds {found:?}, declared are {expected:?}", kernel.name));
        }
        let entry: Vec<_> =
            self.module.entry_points.iter().map(|e| (e.name.as_str(), e.workgroup_size)).collect();
        if entry != [("main", [kernel.workgroup, 1, 1])] {
            return Err(format!(
                "`{}` has the entry points {entry:?}, expected `main` with workgroups of {}",
                kernel.name, kernel.workgroup
            ));
        }
        Ok(())
    }

    /// Bytes of memory that a workgroup shares.
    pub fn shared_bytes(&self) -> u32 {
        self.bytes_in(AddressSpace::WorkGroup)
    }

    /// Bytes of variables that each thread has: what registers must hold at most, unless the driver finds that not all live at
    /// once.
    pub fn thread_bytes(&self) -> u32 {
        let Some(layouter) = self.layouter() else { return 0 };
        let functions = self.module.functions.iter().map(|(_, function)| function);
        let functions = functions.chain(self.module.entry_points.iter().map(|entry| &entry.function));
        let locals = functions.flat_map(|function| function.local_variables.iter());
        locals.map(|(_, local)| layouter[local.ty].size).sum::<u32>() + self.bytes_in(AddressSpace::Private)
    }

    fn bytes_in(&self, space: AddressSpace) -> u32 {
        let Some(layouter) = self.layouter() else { return 0 };
        let variables = self.module.global_variables.iter().filter(|(_, variable)| variable.space == space);
        variables.map(|(_, variable)| layouter[variable.ty].size).sum()
    }

    fn layouter(&self) -> Option<naga::proc::Layouter> {
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(self.module.to_ctx()).ok().map(|()| layouter)
    }
}
