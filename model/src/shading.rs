//! Shading: what a surface looks like where a ray hits it (§2: extended Phong, an image texture
//! and a bump map a surface, Stated; the formulas are Assumed).
//!
//! Colours are display values, as in graphics chips of the time: no conversion to or from a
//! linear space takes place.

use crate::image::{ImageRecord, MaterialRecord, Registers, ShadingRecord};
use crate::memory::{Memory, Port};
use crate::ray::{Hits, Packet};
use crate::scene::{Features, Light, TexelFormat};
use crate::units::HostAddr;
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

/// The surfaces that the rays of a packet hit; none where a ray hit nothing (SH-1).
///
/// The material and the shading record of a triangle are read once for all rays of the packet
/// that hit it; texels are read for each ray.
pub fn surfaces<const N: usize>(
    memory: &mut impl Memory,
    registers: &Registers,
    packet: &Packet<N>,
    hits: &Hits<N>,
) -> [Option<Surface>; N] {
    let mut surfaces = [None; N];
    let mut pending: [bool; N] = std::array::from_fn(|lane| hits.is_hit(lane));
    for first in 0..N {
        if !pending[first] {
            continue;
        }
        let triangle = hits.triangle[first];
        memory.issue(Port::Shading, || hits.triangle.iter().filter(|&&hit| hit == triangle).count() as u32);
        let (record, material) = read_records(memory, registers, HostAddr(triangle));
        for lane in first..N {
            if pending[lane] && hits.triangle[lane] == triangle {
                pending[lane] = false;
                let (weights, t) = ([hits.u[lane], hits.v[lane]], hits.t[lane]);
                let (origin, direction) = (packet.origin(lane), packet.direction(lane));
                surfaces[lane] = Some(surface(memory, &record, &material, origin, direction, t, weights));
            }
        }
    }
    surfaces
}

/// Reads what is known of the triangle at `triangle`.
fn read_records(
    memory: &mut impl Memory,
    registers: &Registers,
    triangle: HostAddr,
) -> (ShadingRecord, MaterialRecord) {
    let features = registers.features;
    let mut bytes = [0; Features::MAX_RECORD_BYTES];
    let record = &mut bytes[..features.shading_record_bytes() as usize];
    let index = registers.triangle_index(triangle);
    memory.read(Port::Shading, registers.shading.offset(index * features.shading_record_bytes()), record);
    let record = ShadingRecord::decode(record, features);
    let material = &mut bytes[..features.material_bytes() as usize];
    memory.read(Port::Shading, record.material, material);
    (record, MaterialRecord::decode(material, features))
}

/// The surface at distance `t` and barycentric `weights` of the second and third corner.
fn surface(
    memory: &mut impl Memory,
    record: &ShadingRecord,
    material: &MaterialRecord,
    origin: Vec3,
    direction: Vec3,
    t: f32,
    [u, v]: [f32; 2],
) -> Surface {
    let uv = interpolate(record.tex_coords, u, v);
    let mut normal = interpolate(record.normals, u, v).normalize_or(record.normal);
    if let Some((map, height)) = material.bump {
        normal = bumped(memory, record, normal, map, height, uv);
    }
    let diffuse = match material.texture {
        Some(image) => material.diffuse * sample_colour(memory, image, uv),
        None => material.diffuse,
    };
    let front = record.normal.dot(direction) < 0.0;
    let plane_normal = if front { record.normal } else { -record.normal };
    let normal = if normal.dot(direction) < 0.0 { normal } else { -normal };
    let point = origin + direction * t;
    let scale = origin.abs().max(point.abs()).max_element();
    Surface { point, scale, direction, plane_normal, normal, front, diffuse, material: *material }
}

/// The value at barycentric weights `u` and `v` of the second and the third corner.
fn interpolate<T>([a, b, c]: [T; 3], u: f32, v: f32) -> T
where
    T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    a * (1.0 - u - v) + b * u + c * v
}

/// Where a texture coordinate lies among the texels of an image (SH-2).
///
/// The image tiles; v runs upwards, rows downwards; texels have their values at their centres.
struct Footprint {
    /// Columns and rows of the four texels around the point.
    columns: [u32; 2],
    rows: [u32; 2],
    /// How far the point is from the first of them, to the right and downwards: 0 to 1.
    fraction: Vec2,
}

impl Footprint {
    fn new(image: ImageRecord, uv: Vec2) -> Self {
        let tile = |place: f32, size: u32| {
            // Rounding can give 1.0 itself, which is the first texel of the next tile.
            let texel = (place - place.floor()) * size as f32 - 0.5;
            let below = texel.floor();
            let first = (below as i64).rem_euclid(i64::from(size)) as u32;
            ([first, (first + 1) % size], texel - below)
        };
        let (columns, right) = tile(uv.x, image.width);
        let (rows, down) = tile(1.0 - uv.y, image.height);
        Self { columns, rows, fraction: Vec2::new(right, down) }
    }
}

/// Reads the texel in `column` and `row`.
fn texel<const BYTES: usize>(
    memory: &mut impl Memory,
    image: ImageRecord,
    column: u32,
    row: u32,
) -> [u8; BYTES] {
    memory.fetch(Port::Shading, image.texels.offset(image.place(column, row) * BYTES as u32))
}

/// The colour of an image at `uv`, by bilinear interpolation (SH-2).
fn sample_colour(memory: &mut impl Memory, image: ImageRecord, uv: Vec2) -> Vec3 {
    const BYTES: usize = TexelFormat::Rgba8.texel_bytes() as usize;
    let Footprint { columns, rows, fraction } = Footprint::new(image, uv);
    let [top, bottom] = rows.map(|row| {
        let [left, right] = columns.map(|column| {
            let [red, green, blue, _alpha] = texel::<BYTES>(memory, image, column, row);
            Vec3::new(f32::from(red), f32::from(green), f32::from(blue)) / 255.0
        });
        left.lerp(right, fraction.x)
    });
    top.lerp(bottom, fraction.y)
}

/// The normal that a bump map gives the surface (SH-2): tilted by the slope of the height field
/// between the four texels around the point (after Blinn 1978), texels being square.
fn bumped(
    memory: &mut impl Memory,
    record: &ShadingRecord,
    normal: Vec3,
    map: ImageRecord,
    height: f32,
    uv: Vec2,
) -> Vec3 {
    const BYTES: usize = TexelFormat::Height8.texel_bytes() as usize;
    let Footprint { columns, rows, .. } = Footprint::new(map, uv);
    let [[top_left, top_right], [bottom_left, bottom_right]] = rows.map(|row| {
        columns.map(|column| height * f32::from(texel::<BYTES>(memory, map, column, row)[0]) / 255.0)
    });
    let slope_right = (top_right - top_left + bottom_right - bottom_left) / 2.0;
    let slope_up = (top_left - bottom_left + top_right - bottom_right) / 2.0;
    // The direction of growing v, which may be mirrored against that of growing u.
    let [a, b, c] = record.tex_coords;
    let upwards = normal.cross(record.tangent) * (b - a).perp_dot(c - a).signum();
    (normal - record.tangent * slope_right - upwards * slope_up).normalize_or(normal)
}

impl Surface {
    /// The colour of a surface in a scene without lights: its own, darker where it is seen from
    /// the side (SH-3).
    #[must_use]
    pub fn unlit(&self) -> Vec3 {
        self.diffuse * (AMBIENT + (1.0 - AMBIENT) * self.facing())
    }

    /// The colour of a surface that no light reaches, in a scene with lights: half as bright where
    /// it is seen from the side, so that shapes show in the shadow (SH-3).
    #[must_use]
    pub fn ambient(&self) -> Vec3 {
        self.diffuse * (AMBIENT * (1.0 + self.facing()) / 2.0)
    }

    /// How much the surface faces the viewer: 1 straight, 0 seen from the side.
    fn facing(&self) -> f32 {
        -self.normal.dot(self.direction)
    }

    /// What `light` adds where nothing is in its way: Phong's diffuse and specular terms (SH-3).
    #[must_use]
    pub fn lit(&self, light: &Light) -> Vec3 {
        let to_light = (light.position - self.point).normalize_or_zero();
        let facing = self.normal.dot(to_light);
        if facing <= 0.0 {
            return Vec3::ZERO;
        }
        let mut colour = self.diffuse * facing;
        if self.material.specular != Vec3::ZERO {
            let glance = to_light.dot(self.mirrored()).max(0.0);
            colour += self.material.specular * glance.powf(self.material.shininess);
        }
        colour * ((1.0 - AMBIENT) * light.intensity)
    }

    /// Direction of the mirrored ray.
    #[must_use]
    pub fn mirrored(&self) -> Vec3 {
        self.direction - self.normal * (2.0 * self.normal.dot(self.direction))
    }

    /// Direction of the refracted ray by Snell's law; of the mirrored one where all light is
    /// reflected. Behind the front lies the material, before it lies air.
    #[must_use]
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

    /// An image of 2 × 2 texels, black, red; green, blue, in a memory of its own: column by column.
    struct Texels;

    const IMAGE: ImageRecord = ImageRecord { texels: HostAddr(0), width: 2, height: 2 };

    impl Memory for Texels {
        fn read(&mut self, port: Port, addr: HostAddr, bytes: &mut [u8]) {
            assert_eq!(port, Port::Shading);
            let texels = [0, 0, 0, 255, 0, 255, 0, 255, 255, 0, 0, 255, 0, 0, 255, 255];
            bytes.copy_from_slice(&texels[addr.0 as usize..][..bytes.len()]);
        }
    }

    #[test]
    fn texels_are_met_at_their_centres_with_v_upwards() {
        let at = |u, v| sample_colour(&mut Texels, IMAGE, Vec2::new(u, v));
        assert_eq!(at(0.25, 0.75), Vec3::ZERO);
        assert_eq!(at(0.75, 0.75), Vec3::X);
        assert_eq!(at(0.25, 0.25), Vec3::Y);
        assert_eq!(at(0.75, 0.25), Vec3::Z);
        assert_eq!(at(0.5, 0.75), Vec3::X / 2.0);
    }

    #[test]
    fn images_tile() {
        let at = |u, v| sample_colour(&mut Texels, IMAGE, Vec2::new(u, v));
        assert_eq!(at(-3.75, 5.75), at(0.25, 0.75));
        // Half way between the last column and the first of the next tile.
        assert_eq!(at(1.0, 0.75), Vec3::X / 2.0);
        // Far off, or nowhere: some texel, no panic.
        at(1e30, -1e30);
        at(f32::NAN, f32::INFINITY);
    }

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
