//! Pictures of a scene on a compute device, as fast as a window wants them. They agree closely with those of the processor, not
//! bit for bit, so they serve as previews and are no node's answer.

use breccia_shaders::kernels::MARCH;
use breccia_shaders::{Batch, Buffer, Gpu, GpuError, Groups};
use bytemuck::{Pod, Zeroable};

use super::cutaway::to_world;
use super::error::{RenderError, check_picture};
use super::march::Scene;
use super::studio::{Seen, compose};
use super::translucent::TranslucentSettings;
use super::vector::Vec3;
use crate::control::Control;
use crate::data::{Image, SolidError};

/// A scene in a device's memory, where it stays between pictures.
pub struct DeviceScene {
    voxels: Buffer,
    flags: Buffer,
}

/// `Params` of `kernels/render/march.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct MarchParams {
    eye: [f32; 4],
    ray: [f32; 4],
    right: [f32; 4],
    down: [f32; 4],
    light: [f32; 4],
    cuts: [[f32; 4]; 3],
    size: [i32; 4],
    width: u32,
    height: u32,
    first: u32,
    rest: u32,
}

/// A vector as the device takes it.
fn four(v: Vec3, last: f64) -> [f32; 4] {
    [v[0] as f32, v[1] as f32, v[2] as f32, last as f32]
}

impl DeviceScene {
    /// Copies a scene to a device: four and a quarter bytes a voxel.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] beyond what the device takes.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, GpuError> {
        gpu.scope(|| Ok(Self { voxels: gpu.upload(&scene.voxels)?, flags: gpu.upload(&scene.flags)? }))
    }

    /// Draws the scene and leaves the picture on the device: for each pixel, row by row, four 32-bit floats, linear light times
    /// coverage and coverage. `scene` is the one that was copied.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`] between submissions, or what the device says.
    pub fn draw(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        settings: &TranslucentSettings,
        control: &dyn Control,
    ) -> Result<Buffer, GpuError> {
        let [width, height] = settings.picture;
        let view = scene.view(settings);
        let ray = |x: f64, y: f64| to_world(view.camera.ray(x, y));
        let corner = ray(0.0, 0.0);
        // Rays are linear in the place.
        let along = |x: f64, y: f64| -> Vec3 { std::array::from_fn(|i| ray(x, y)[i] - corner[i]) };
        let [w, h] = [width, height].map(f64::from);
        let mut cuts = [[0.0; 4]; 3];
        cuts.iter_mut().zip(&view.cuts).for_each(|(to, &(normal, distance))| *to = four(normal, distance));
        let [x, y, z] = scene.size.map(|n| n as i32);
        let params = MarchParams {
            eye: four(to_world(view.camera.eye()), 0.0),
            ray: four(corner, 0.0),
            right: four(along(w, 0.0).map(|c| c / w), 0.0),
            down: four(along(0.0, h).map(|c| c / h), 0.0),
            light: four(view.light, 0.0),
            cuts,
            size: [x, y, z, 0],
            width,
            height,
            first: 0,
            rest: 0,
        };
        let tables: Vec<f32> =
            view.opacities.iter().chain(&view.linear).map(|&number| number as f32).collect();
        gpu.scope(|| {
            let tables = gpu.upload(&tables)?;
            let out = gpu.zeros(u64::from(width) * u64::from(height) * 16)?;
            Batch::new(gpu).dispatch_long(
                &MARCH,
                |first| MarchParams { first, ..params },
                &[&tables, &self.voxels, &self.flags, &out],
                Groups(width.div_ceil(8) * height.div_ceil(8)),
                &|| control.is_cancelled(),
            )?;
            Ok(out)
        })
    }
}

/// [`Scene::picture`] with the rays marched on a device; on the processor if the device is lost. The bytes differ by less than 0.1 in
/// the mean; by more than 8 only where rays graze a voxel, in less than one pixel of 200.
///
/// # Errors
/// [`RenderError`]: an impossible size, cancelled, or what the device says.
pub fn march_on_device(
    gpu: &Gpu,
    scene: &Scene,
    settings: &TranslucentSettings,
    control: &dyn Control,
) -> Result<Image, RenderError> {
    check_picture(settings.picture)?;
    let [width, height] = settings.picture;
    let mut pixels = vec![[0.0f32; 4]; width as usize * height as usize];
    let drawn = DeviceScene::new(gpu, scene)
        .and_then(|device| device.draw(gpu, scene, settings, control))
        .and_then(|out| gpu.scope(|| Batch::new(gpu).read(&out, &mut pixels)));
    match drawn {
        Err(error @ GpuError::Lost(_)) => {
            control.device_lost(&error);
            return scene.picture(settings, control);
        }
        drawn => drawn.map_err(SolidError::from)?,
    }
    compose(settings.picture, settings.background, control, |column, row| {
        let [r, g, b, cover] = pixels[row as usize * width as usize + column as usize].map(f64::from);
        Seen { color: [r, g, b], object: cover, shadow: 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::super::Background;
    use super::super::march::tests::{SETTINGS, halves};
    use super::super::translucent::{Cut, Key, translucent_scene};
    use super::*;
    use crate::control::testing::OnDevice;
    use crate::solid::{CheckerSolid, Shape, ShapeSolid};

    /// How far apart two pictures are: the mean over all bytes, and the share of pixels that differ by more than 8.
    fn apart(a: &Image, b: &Image) -> (f64, f64) {
        let (mut sum, mut wrong) = (0.0, 0.0);
        let count = f64::from(a.width() * a.height());
        for (x, y) in (0..a.height()).flat_map(|y| (0..a.width()).map(move |x| (x, y))) {
            let gaps: Vec<f64> = (0..a.channels())
                .map(|c| f64::from((a.get(x, y, c) - b.get(x, y, c)).abs()) * 255.0)
                .collect();
            sum += gaps.iter().sum::<f64>() / (count * a.channels() as f64);
            wrong += f64::from(gaps.iter().any(|&gap| gap > 8.5)) / count;
        }
        (sum, wrong)
    }

    /// Rays that graze the edge of a voxel may pass on its other side; elsewhere there is no difference worth speaking of.
    #[test]
    fn on_the_device_pictures_agree_but_for_rays_that_graze_a_voxel() {
        let Some(device) = OnDevice::open(Default::default()) else { return };
        let checker = CheckerSolid { colors: [[230, 200, 150], [60, 40, 90]], cell: 5, noise: 40, seed: 3 };
        let ball = ShapeSolid { shape: Shape::Ball, center: [12; 3], radius: [9; 3] };
        let place = ([0; 3], [24, 20, 28]);
        let marked = translucent_scene(&checker, Some(&ball), None, place, Key::Luminance, &()).unwrap();
        let inside = translucent_scene(&checker, None, Some(&ball), place, Key::Luminance, &()).unwrap();
        let labels =
            translucent_scene(&halves(), None, None, ([-3, 0, -2], [18; 3]), Key::Label, &()).unwrap();
        let cut = |normal, at| Some(Cut { normal, at });
        let glass = TranslucentSettings { opacities: [0.03; 256], view: [36.0, 27.0], ..SETTINGS };
        let cases = [
            (&marked, glass),
            (&marked, TranslucentSettings { cuts: [cut([1.0, -0.4, -0.7], 0.5), None, None], ..glass }),
            (&inside, TranslucentSettings { opacities: [1.0; 256], view: [-120.0, -50.0], ..glass }),
            (
                &inside,
                TranslucentSettings {
                    opacities: Key::Luminance.opacities(&[1.0, 0.2, 0.0, 0.05], 0.0),
                    cuts: [
                        cut([0.0, -1.0, 0.0], 0.61),
                        cut([0.3, 0.1, -1.0], 0.4),
                        cut([1.0, 0.0, 0.0], 0.73),
                    ],
                    background: Background::Neutral,
                    ..glass
                },
            ),
            (
                &labels,
                TranslucentSettings { opacities: Key::Label.opacities(&[0.0, 0.08, 1.0], 0.0), ..glass },
            ),
        ];
        for (i, (scene, settings)) in cases.into_iter().enumerate() {
            let settings = TranslucentSettings { picture: [120, 90], ..settings };
            let on_cpu = scene.picture(&settings, &()).unwrap();
            let on_gpu = march_on_device(&device.gpu, scene, &settings, &device).unwrap();
            let (mean, wrong) = apart(&on_gpu, &on_cpu);
            assert!(mean < 0.1 && wrong < 0.005, "case {i}: {mean} in the mean, {wrong} of the pixels");
        }
    }

    #[test]
    fn on_the_device_cancelling_stops_a_picture() {
        struct Never(OnDevice);
        impl Control for Never {
            fn is_cancelled(&self) -> bool {
                true
            }
        }
        let Some(device) = OnDevice::open(Default::default()) else { return };
        let device = Never(device);
        let scene = translucent_scene(&halves(), None, None, ([0; 3], [12; 3]), Key::Label, &()).unwrap();
        let drawn = march_on_device(&device.0.gpu, &scene, &SETTINGS, &device);
        assert!(matches!(drawn, Err(RenderError::Solid(SolidError::Cancelled))));
    }

    #[test]
    fn on_the_device_that_is_lost_the_processor_draws() {
        let Some(device) = OnDevice::open(Default::default()) else { return };
        device.gpu.lose_after(0);
        let scene = translucent_scene(&halves(), None, None, ([0; 3], [12; 3]), Key::Label, &()).unwrap();
        let drawn = march_on_device(&device.gpu, &scene, &SETTINGS, &device).unwrap();
        assert_eq!(drawn, scene.picture(&SETTINGS, &()).unwrap());
        assert_eq!(device.losses(), 1);
    }
}
