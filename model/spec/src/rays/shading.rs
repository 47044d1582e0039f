//! Shading: what a surface looks like where a ray hits it (§2: extended Phong, an image texture
//! and a bump map a surface, Stated; the formulas are Assumed).
//!
//! Colours are display values, as in graphics chips of the time: no conversion to or from a
//! linear space takes place.

use super::ray::{Hits, Packet};
use super::texel::{sample_colour, sample_slope};
use crate::host::{Features, Light, MaterialRecord, Registers, ShadingRecord};
use crate::vm::{HostAddr, Memory, Observed, Observer, Unit};
use glam::{Vec2, Vec3};

/// Part of a surface's colour that does not depend on lights (SH-3, Assumed).
pub const AMBIENT: f32 = 0.3;

/// Colour where a ray hits nothing (SH-4, Assumed).
pub const BACKGROUND: Vec3 = Vec3::new(0.55, 0.65, 0.75);

/// A point of a surface as a ray sees it, ready to be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The point hit.
    pub point: Vec3,
    /// The largest coordinate that `point` was computed from.
    pub scale: f32,
    /// Distance from the eye, along the rays that led here.
    pub distance: f32,
    /// Unit direction of the ray.
    pub direction: Vec3,
    /// Unit normal of the triangle's plane, on the side of the ray's origin.
    pub plane_normal: Vec3,
    /// Unit normal to shade with, on the side of the ray's origin.
    pub normal: Vec3,
    /// Whether the ray meets the side from which the corners run counter-clockwise.
    pub front: bool,
    /// Diffuse reflectance, with the texture.
    pub diffuse: Vec3,
    /// The material.
    pub material: MaterialRecord,
}

/// The cones around a packet's rays: what a pixel sees (Amanatides 1984). Mirrors and glass are taken
/// for flat, so that a cone stays as wide as its pixel (SH-6, Assumed).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cones<const N: usize> {
    /// Width at distance 1.
    pub spread: f32,
    /// Distance from the eye at which each ray begins, along the rays that led there.
    pub begin: [f32; N],
}

/// The surfaces that the rays of a packet hit; none where a ray hit nothing (SH-1).
///
/// The material and the shading record of a triangle are read once for all rays of the packet
/// that hit it; texels are read for each ray.
pub fn surfaces<const N: usize>(
    memory: &mut Observed<impl Memory, impl Observer>,
    registers: &Registers,
    packet: &Packet<N>,
    hits: &Hits<N>,
    cones: &Cones<N>,
) -> [Option<Surface>; N] {
    let mut surfaces = [None; N];
    let mut pending: [bool; N] = std::array::from_fn(|lane| hits.is_hit(lane));
    for first in 0..N {
        if !pending[first] {
            continue;
        }
        let triangle = hits.triangle[first];
        memory.operation(Unit::Shading, hits.triangle.iter().filter(|&&hit| hit == triangle).count() as u32);
        let (record, material) = read_records(memory, registers, HostAddr(triangle));
        for lane in first..N {
            if pending[lane] && hits.triangle[lane] == triangle {
                pending[lane] = false;
                surfaces[lane] = Some(surface(memory, &record, &material, packet, hits, cones, lane));
            }
        }
    }
    surfaces
}

/// Reads what is known of the triangle at `triangle`.
fn read_records(
    memory: &mut Observed<impl Memory, impl Observer>,
    registers: &Registers,
    triangle: HostAddr,
) -> (ShadingRecord, MaterialRecord) {
    let features = registers.features;
    let mut bytes = [0; Features::MAX_RECORD_BYTES];
    let record = &mut bytes[..features.shading_record_bytes() as usize];
    let index = registers.triangle_index(triangle);
    memory.read(Unit::Shading, registers.shading.offset(index * features.shading_record_bytes()), record);
    let record = ShadingRecord::decode(record, features);
    let material = &mut bytes[..features.material_bytes() as usize];
    memory.read(Unit::Shading, record.material, material);
    (record, MaterialRecord::decode(material, features))
}

/// The surface that the ray in `lane` meets.
fn surface<const N: usize>(
    memory: &mut Observed<impl Memory, impl Observer>,
    record: &ShadingRecord,
    material: &MaterialRecord,
    packet: &Packet<N>,
    hits: &Hits<N>,
    cones: &Cones<N>,
    lane: usize,
) -> Surface {
    let (origin, direction) = (packet.origin(lane), packet.direction(lane));
    let (t, u, v) = (hits.t[lane], hits.u[lane], hits.v[lane]);
    let (point, distance) = (origin + direction * t, cones.begin[lane] + t);
    let uv = interpolate(record.tex_coords, u, v);
    // The cone's width at the surface, along the way in which it is seen from the side.
    let width = cones.spread * distance / record.normal.dot(direction);
    let area = width * width * record.texture_density;
    let mut normal = interpolate(record.normals, u, v).normalize_or(record.normal);
    if let Some((map, height)) = material.bump {
        normal = bumped(record, normal, sample_slope(memory, map, height, uv, area));
    }
    let diffuse = match material.texture {
        Some(image) => material.diffuse * sample_colour(memory, image, uv, area),
        None => material.diffuse,
    };
    let front = record.normal.dot(direction) < 0.0;
    let plane_normal = if front { record.normal } else { -record.normal };
    let normal = if normal.dot(direction) < 0.0 { normal } else { -normal };
    let scale = origin.abs().max(point.abs()).max_element();
    Surface { point, scale, distance, direction, plane_normal, normal, front, diffuse, material: *material }
}

/// The value at barycentric weights `u` and `v` of the second and the third corner.
fn interpolate<T>([a, b, c]: [T; 3], u: f32, v: f32) -> T
where
    T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    a * (1.0 - u - v) + b * u + c * v
}

/// The normal that a bump map's `slope` gives the surface: tilted by it (SH-2, after Blinn 1978).
fn bumped(record: &ShadingRecord, normal: Vec3, slope: Vec2) -> Vec3 {
    // The direction of growing v, which may be mirrored against that of growing u.
    let [a, b, c] = record.tex_coords;
    let upwards = normal.cross(record.tangent) * (b - a).perp_dot(c - a).signum();
    (normal - record.tangent * slope.x - upwards * slope.y).normalize_or(normal)
}

impl Surface {
    /// The colour of a surface in a scene without lights: its own, darker where it is seen from
    /// the side (SH-3).
    pub fn unlit(&self) -> Vec3 {
        self.diffuse * (AMBIENT + (1.0 - AMBIENT) * self.facing())
    }

    /// The colour of a surface that no light reaches, in a scene with lights: half as bright where
    /// it is seen from the side, so that shapes show in the shadow (SH-3).
    pub fn ambient(&self) -> Vec3 {
        self.diffuse * (AMBIENT * (1.0 + self.facing()) / 2.0)
    }

    /// How much the surface faces the viewer: 1 straight, 0 seen from the side.
    fn facing(&self) -> f32 {
        -self.normal.dot(self.direction)
    }

    /// What `light` adds where nothing is in its way: Phong's diffuse and specular terms (SH-3).
    pub fn lit(&self, light: &Light) -> Vec3 {
        let to_light = (light.position - self.point).normalize_or_zero();
        let facing = self.normal.dot(to_light);
        if facing <= 0.0 {
            return Vec3::ZERO;
        }
        let mut colour = self.diffuse * facing;
        if self.material.specular != Vec3::ZERO {
            let glance = to_light.dot(self.mirrored()).max(0.0);
            colour += self.material.specular * libm::powf(glance, self.material.shininess);
        }
        colour * ((1.0 - AMBIENT) * light.intensity)
    }

    /// Direction of the mirrored ray.
    pub fn mirrored(&self) -> Vec3 {
        self.direction - self.normal * (2.0 * self.normal.dot(self.direction))
    }

    /// Direction of the refracted ray by Snell's law; of the mirrored one where all light is
    /// reflected. Behind the front lies the material, before it lies air.
    pub fn refracted(&self) -> Vec3 {
        let index = self.material.index_of_refraction;
        let ratio = if self.front { 1.0 / index } else { index };
        let cosine = -self.normal.dot(self.direction);
        let square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        if square <= 0.0 {
            return self.mirrored();
        }
        (self.direction * ratio + self.normal * (ratio * cosine - square.sqrt())).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// A surface in the plane z = 0, seen from above at 45 degrees.
    fn surface(index_of_refraction: f32, front: bool) -> Surface {
        let material = MaterialRecord {
            diffuse: Vec3::ONE,
            specular: Vec3::ZERO,
            shininess: 1.0,
            reflection: 0.0,
            refraction: 1.0,
            index_of_refraction,
            texture: None,
            bump: None,
        };
        Surface {
            point: Vec3::ZERO,
            scale: 1.0,
            distance: 1.0,
            direction: Vec3::new(1.0, 0.0, -1.0).normalize(),
            plane_normal: Vec3::Z,
            normal: Vec3::Z,
            front,
            diffuse: Vec3::ONE,
            material,
        }
    }

    #[test]
    fn refraction_obeys_snell() {
        let refracted = surface(1.5, true).refracted();
        assert_relative_eq!(refracted.x, std::f32::consts::FRAC_1_SQRT_2 / 1.5, epsilon = 1e-6);
        assert!(refracted.z < 0.0);
        // From the inside, 45 degrees are beyond the critical angle of 41.8.
        let inside = surface(1.5, false);
        assert_eq!(inside.refracted(), inside.mirrored());
    }

    #[test]
    fn light_from_behind_adds_nothing() {
        let light = |z| Light { position: Vec3::Z * z, intensity: 0.5 };
        assert_eq!(surface(1.0, true).lit(&light(-1.0)), Vec3::ZERO);
        assert_eq!(surface(1.0, true).lit(&light(2.0)), Vec3::splat(0.5 * (1.0 - AMBIENT)));
    }
}
