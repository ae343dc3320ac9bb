//! What a surface looks like at a place: texture maps, and how they answer light.

use super::light::{Lights, Reaching};
use super::surface::{Surface, blend};
use super::texture::{Encoding, Texture};
use super::vector::{Vec3, add, dot, scale, sub, unit_or};
use crate::data::Mesh;

/// The grey of a mesh without colours.
const CLAY: Vec3 = [0.52, 0.52, 0.50];
/// The roughness of a mesh without such a map.
const ROUGHNESS: f64 = 0.62;

/// The texture maps of a mesh.
pub(super) struct Material {
    color: Option<Texture>,
    normal: Option<Texture>,
    roughness: Option<Texture>,
    metallic: Option<Texture>,
}

/// A point of the surface that is seen.
pub(super) struct Point {
    pub triangle: usize,
    /// Weights of the triangle's corners.
    pub weights: Vec3,
    /// The unit normal, towards the viewer.
    pub normal: Vec3,
    /// Towards the viewer.
    pub view: Vec3,
    /// How far texture coordinates move from one sample to the next, along both picture axes.
    pub steps: [[f64; 2]; 2],
}

impl Material {
    /// The maps of a mesh, ready for look-ups; none without texture coordinates.
    pub fn new(mesh: &Mesh, surface: &Surface) -> Self {
        let map = |name: &str, encoding| {
            let image = mesh.texture(name).filter(|_| !surface.uvs.is_empty())?;
            Some(Texture::new(image, encoding))
        };
        Self {
            color: map("color", Encoding::Srgb),
            normal: map("normal", Encoding::Linear),
            roughness: map("roughness", Encoding::Linear),
            metallic: map("metallic", Encoding::Linear),
        }
    }

    /// The linear light that a point sends to the viewer.
    pub fn shade(&self, surface: &Surface, point: &Point, lights: &Lights, reaching: &Reaching) -> Vec3 {
        let uv = surface.uvs.get(point.triangle).map(|corners| mix_uv(corners, point.weights));
        let look = |texture: &Option<Texture>| {
            let (texture, uv) = (texture.as_ref()?, uv?);
            Some(texture.sample(uv, lod(texture, &point.steps)))
        };
        let vertex = || surface.colors.get(point.triangle).map(|corners| blend(corners, point.weights));
        let albedo = look(&self.color).or_else(vertex).unwrap_or(CLAY);
        let roughness = look(&self.roughness).map_or(ROUGHNESS, |r| r[0]).clamp(0.08, 1.0);
        let metallic = look(&self.metallic).map_or(0.0, |m| m[0]);
        let normal = match look(&self.normal) {
            Some(texel) => bent(surface, point, texel),
            None => point.normal,
        };

        let diffuse = lights.irradiance(reaching, normal) * (1.0 - metallic);
        let facing = dot(normal, point.view).clamp(0.0, 1.0);
        let open = lights.openness(reaching, point.normal);
        let mirrored = sub(scale(normal, 2.0 * dot(normal, point.view)), point.view);
        let glossy = lights.reflected(mirrored, roughness) * open;
        let key = ggx(normal, point.view, lights.key(), roughness)
            * lights.key_power()
            * lights.key_fraction(reaching);
        std::array::from_fn(|c| {
            let base = 0.04 + (albedo[c] - 0.04) * metallic;
            let grazing = libm::pow(1.0 - facing, 5.0) * (1.0 - roughness) * (1.0 - roughness);
            let mirror = base + (1.0 - base) * grazing;
            shoulder(albedo[c] * diffuse + mirror * glossy + base * key)
        })
    }
}

/// The level at which a sample of the picture is about one texel wide.
fn lod(texture: &Texture, steps: &[[f64; 2]; 2]) -> f64 {
    let size = texture.size();
    let texels = steps.map(|[u, v]| {
        let (x, y) = (u * size[0], v * size[1]);
        (x * x + y * y).max(1e-30)
    });
    0.25 * libm::log2(texels[0] * texels[1])
}

fn mix_uv(corners: &[[f64; 2]; 3], weights: Vec3) -> [f64; 2] {
    std::array::from_fn(|i| {
        corners[0][i] * weights[0] + corners[1][i] * weights[1] + corners[2][i] * weights[2]
    })
}

/// The normal turned by a tangent-space normal map: red along u, green against v (up in the map), blue out.
fn bent(surface: &Surface, point: &Point, texel: Vec3) -> Vec3 {
    let (Some([a, b, c]), Some([ua, ub, uc])) =
        (surface.corners.get(point.triangle), surface.uvs.get(point.triangle))
    else {
        return point.normal;
    };
    let (e1, e2) = (sub(*b, *a), sub(*c, *a));
    let (d1, d2) = ([ub[0] - ua[0], ub[1] - ua[1]], [uc[0] - ua[0], uc[1] - ua[1]]);
    let det = d1[0] * d2[1] - d2[0] * d1[1];
    if det == 0.0 || !det.is_finite() {
        return point.normal;
    }
    let along_u = scale(sub(scale(e1, d2[1]), scale(e2, d1[1])), det.signum());
    let against_v = scale(sub(scale(e1, d2[0]), scale(e2, d1[0])), det.signum());
    let flat = |v: Vec3| unit_or(sub(v, scale(point.normal, dot(v, point.normal))), [0.0; 3]);
    let [x, y, z] = texel.map(|c| 2.0 * c - 1.0);
    let turned =
        add(add(scale(flat(along_u), x), scale(flat(against_v), y)), scale(point.normal, z.max(0.05)));
    unit_or(turned, point.normal)
}

/// The specular lobe of Trowbridge and Reitz with Smith's shadowing, for a reflectance of 1, times the cosine.
fn ggx(normal: Vec3, view: Vec3, light: Vec3, roughness: f64) -> f64 {
    let (nl, nv) = (dot(normal, light), dot(normal, view).max(0.02));
    if nl <= 0.0 {
        return 0.0;
    }
    let half = unit_or(add(view, light), normal);
    let nh = dot(normal, half).max(0.0);
    let a2 = roughness * roughness * roughness * roughness;
    let d = nh * nh * (a2 - 1.0) + 1.0;
    let smith = |c: f64| c + (a2 + (1.0 - a2) * c * c).sqrt();
    // D · G / (4 nl nv) · nl, with G's numerator cancelled; power is irradiance, hence no π.
    a2 / (d * d) * nl / (smith(nl) * smith(nv))
}

/// Keeps light above 0.8 from clipping hard at 1.
fn shoulder(light: f64) -> f64 {
    let knee = 0.8;
    if light < knee { light } else { 1.0 - (1.0 - knee) * libm::exp((knee - light) / (1.0 - knee)) }
}
