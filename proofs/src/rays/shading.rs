//! Theorems of shading (SH-1 to SH-3): what is read for a packet, and what a surface looks like.
//!
//! Numbers are few powers of two and sums of them, so that but for square roots nothing is rounded; what is
//! normalised is compared in f64.

use super::noise;
use crate::draw::{self, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use glam::{DVec3, Vec2, Vec3};
use saarcor_model::host::{
    Aabb, Edges, Features, Kernel, Light, MaterialRecord, Registers, ShadingRecord, TRIANGLE_BYTES,
    TextureRecord,
};
use saarcor_model::rays::{
    AMBIENT, Cones, Hits, Packet, Ray, Surface, sample_colour, sample_slope, surfaces,
};
use saarcor_model::vm::{HostAddr, Memory, Observed, Observer, Unit};

/// Rays of a packet of the standard configuration.
const RAYS: usize = 64;

/// Where triangles, materials and shading records begin.
const TRIANGLES: HostAddr = HostAddr(0x2000);
const MATERIALS: HostAddr = HostAddr(0x1000_0000);
const SHADING: HostAddr = HostAddr(0x1000_1000);

/// Numbers of triangles: the first ones, around the powers of two, and the last whose record has an address.
static TRIANGLE_NUMBERS: [u32; 7] = [0, 1, 2, 0xffff, 0x1_0000, 0x10_0000, 0x280_0000];

fn features(s: &mut impl Source) -> Features {
    Features {
        textures: draw::flag(s, "textures"),
        bump_maps: draw::flag(s, "bump maps"),
        mip_maps: true,
        lights: 1,
        smooth_normals: draw::flag(s, "smooth normals"),
        highlights: true,
        reflection: false,
        refraction: false,
    }
}

fn registers(features: Features) -> Registers {
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
    let kernel = Kernel::MollerTrumbore;
    Registers {
        root: HostAddr(0),
        bounds,
        kernel,
        edges: Edges::Shared,
        triangles: TRIANGLES,
        shading: SHADING,
        features,
        lights: Vec::new(),
    }
}

/// Memory with records at the addresses where they belong, and texels of noise elsewhere.
struct Records<'a> {
    features: Features,
    /// The record of a triangle, by its number.
    record: &'a dyn Fn(u32) -> ShadingRecord,
    /// The material at an address, by its number.
    material: &'a dyn Fn(u32) -> MaterialRecord,
}

impl Memory for Records<'_> {
    fn read(&mut self, unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        assert_eq!(unit, Unit::Shading);
        let item = |start: HostAddr, size: u32| {
            assert_eq!((addr.0 - start.0) % size, 0, "{addr:?} is where an item begins");
            (addr.0 - start.0) / size
        };
        if bytes.len() <= 4 {
            for (byte, addr) in bytes.iter_mut().zip(addr.0..) {
                *byte = noise(addr) as u8;
            }
        } else if addr >= SHADING {
            let number = item(SHADING, self.features.shading_record_bytes());
            bytes.copy_from_slice(&(self.record)(number).encode(self.features));
        } else {
            let number = item(MATERIALS, self.features.material_bytes());
            bytes.copy_from_slice(&(self.material)(number).encode(self.features));
        }
    }
}

/// Counts what shading does.
#[derive(Default)]
struct Work {
    records: Vec<u32>,
    texels: u32,
    operations: Vec<u32>,
}

impl Observer for Work {
    fn operation(&mut self, _unit: Unit, rays: u32) {
        self.operations.push(rays);
    }

    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: usize) {
        if bytes <= 4 {
            self.texels += 1;
        } else {
            self.records.push(addr.0);
        }
    }
}

/// An image of 8 x 8 texels, and a bump map of 4 x 4.
const IMAGE: TextureRecord = TextureRecord { texels: HostAddr(0x8000_0000), width: 8, height: 8 };
const MAP: TextureRecord = TextureRecord { texels: HostAddr(0xf000_0000), width: 4, height: 4 };

/// A number from a quarter to 2, in sixteenths.
fn some(seed: u32, place: u32) -> f32 {
    (4 + noise(seed.wrapping_mul(64).wrapping_add(place)) % 29) as f32 / 16.0
}

fn some_vector(seed: u32, place: u32) -> Vec3 {
    Vec3::new(some(seed, place), some(seed, place + 1), -some(seed, place + 2))
}

fn material(number: u32) -> MaterialRecord {
    MaterialRecord {
        diffuse: some_vector(number + 7, 0).abs(),
        specular: some_vector(number + 7, 3).abs(),
        shininess: 1.0 + number as f32,
        reflection: 0.0,
        refraction: 0.0,
        index_of_refraction: 1.0,
        texture: (number != 2).then_some(IMAGE),
        bump: (number != 1).then_some((MAP, 2.0)),
    }
}

fn record(number: u32, features: Features) -> ShadingRecord {
    ShadingRecord {
        material: MATERIALS.offset(number % 3 * features.material_bytes()),
        normal: some_vector(number, 0),
        normals: [some_vector(number, 3), some_vector(number, 6), some_vector(number, 9)],
        tex_coords: [12, 14, 16].map(|place| Vec2::new(some(number, place), -some(number, place + 1))),
        texture_density: some(number, 18),
        tangent: some_vector(number, 19),
    }
}

/// What can be seen of a surface, as text: NaN equals itself.
fn seen(surface: &Option<Surface>) -> String {
    format!("{surface:?}")
}

/// Two vectors are the same but for the rounding of a few operations.
fn are_near(found: Vec3, expected: DVec3) -> bool {
    (found.as_dvec3() - expected).abs().max_element() <= 1.0e-6 * (1.0 + expected.length())
}

/// A surface that is seen along `direction`, whose material and other sides are given.
fn surface_of(direction: Vec3, normal: Vec3, front: bool, material: MaterialRecord) -> Surface {
    Surface {
        point: Vec3::new(0.5, -1.0, 2.0),
        scale: 2.0,
        distance: 1.0,
        direction,
        plane_normal: normal,
        normal,
        front,
        diffuse: Vec3::new(0.25, 0.5, 1.0),
        material,
    }
}

/// Unit vectors with coordinates that are known well: along axes, and with components 0.6 and 0.8.
fn unit(s: &mut impl Source, name: &'static str) -> Vec3 {
    let vectors = [
        Vec3::Z,
        Vec3::NEG_Z,
        Vec3::X,
        Vec3::new(0.6, 0.0, 0.8),
        Vec3::new(0.0, -0.6, -0.8),
        Vec3::new(0.8, 0.6, 0.0),
        Vec3::new(-0.8, 0.0, 0.6),
    ];
    vectors[s.value(name, 0..=6, &WORDS[..7]) as usize]
}

/// A material without textures.
fn plain(shininess: f32, index: f32) -> MaterialRecord {
    MaterialRecord {
        specular: Vec3::new(1.0, 0.5, 0.0),
        shininess,
        index_of_refraction: index,
        texture: None,
        bump: None,
        ..material(0)
    }
}

theorems! {
    /// Each of 64 rays sees its surface as if it were alone; for each triangle that any of them hits, its shading
    /// record and its material are read once, where the triangle's number says, and one operation takes all rays that
    /// hit it; texels are read for each ray, four of an image and four of a bump map.
    #[
        "SH-1", not_for_kani "it is arithmetic in floating point",
        covers ["two triangles", "a ray that hits nothing", "the last lane alone", "an image", "a bump map", "beyond triangle 65535"]
    ]
    fn surfaces_are_those_of_each_ray_alone(s) {
        let features = features(s);
        let lane = s.value("lane", 0..=63, &[0, 17, 63_u32]) as usize;
        let own = s.value("triangle of the lane", 0..=0x280_0000, &TRIANGLE_NUMBERS);
        let others = s.value("of every third other (none: nothing)", 0..=0x280_0000, &[0, 1, 0x280_0000]);
        let rest = draw::flag(s, "the rest hits something");
        let mut hits = Hits::<RAYS> { t: [0.0; RAYS], u: [0.0; RAYS], v: [0.0; RAYS], triangle: [Hits::<1>::NOTHING; RAYS] };
        let mut rays = [None; RAYS];
        let mut cones = Cones { spread: 1.0 / 64.0, begin: [0.0; RAYS] };
        for at in 0..RAYS {
            let seed = at as u32 + 100;
            let number = if at == lane { Some(own) } else if at % 3 == 0 { Some(others) } else { rest.then_some(3) };
            rays[at] = Some(Ray { origin: some_vector(seed, 0), direction: some_vector(seed, 3), t_min: 0.0, t_max: f32::INFINITY });
            (hits.t[at], hits.u[at], hits.v[at]) = (some(seed, 6), some(seed, 7) / 4.0, some(seed, 8) / 4.0);
            cones.begin[at] = some(seed, 9);
            if let Some(number) = number {
                hits.triangle[at] = TRIANGLES.0 + number * TRIANGLE_BYTES;
            }
        }
        let registers = registers(features);
        let record = |number: u32| record(number, features);
        let records = || Records { features, record: &record, material: &material };
        let mut memory = Observed { memory: records(), observer: Work::default() };
        let packet = Packet::new(rays);
        let found = surfaces(&mut memory, &registers, &packet, &hits, &cones);
        let Work { records: read, texels, operations } = memory.observer;
        let mut numbers = Vec::new();
        for at in 0..RAYS {
            if hits.is_hit(at) && !numbers.contains(&hits.triangle[at]) {
                numbers.push(hits.triangle[at]);
            }
            if at == lane || at == 0 || at == 62 {
                let alone = Hits::<1> { t: [hits.t[at]], u: [hits.u[at]], v: [hits.v[at]], triangle: [hits.triangle[at]] };
                let cones = Cones { spread: cones.spread, begin: [cones.begin[at]] };
                let expected = surfaces(&mut Observed::by_nobody(records()), &registers, &Packet::new([rays[at]]), &alone, &cones);
                check_eq!(seen(&found[at]), seen(&expected[0]), "lane {at}");
                check_eq!(found[at].is_some(), hits.is_hit(at), "lane {at}");
            }
        }
        let hit = (0..RAYS).filter(|&at| hits.is_hit(at)).count() as u32;
        cover!(s, "two triangles", numbers.len() >= 2);
        cover!(s, "a ray that hits nothing", !rest);
        cover!(s, "the last lane alone", lane == 63 && own != others);
        cover!(s, "an image", features.textures);
        cover!(s, "a bump map", features.bump_maps && !features.textures);
        cover!(s, "beyond triangle 65535", own > 0xffff);
        let (mut expected_reads, mut rays_of_operations) = (Vec::new(), Vec::new());
        let mut expected_texels = 0;
        for &addr in &numbers {
            let number = (addr - TRIANGLES.0) / 36;
            expected_reads.push(SHADING.0 + number * features.shading_record_bytes());
            expected_reads.push(record(number).material.0);
            let count = (0..RAYS).filter(|&at| hits.triangle[at] == addr).count() as u32;
            rays_of_operations.push(count);
            let read = material(number % 3);
            let maps = u32::from(features.textures && read.texture.is_some()) + u32::from(features.bump_maps && read.bump.is_some());
            expected_texels += 4 * maps * count;
        }
        check_eq!(read, expected_reads, "records and materials of the triangles at {numbers:x?}");
        check_eq!(operations, rays_of_operations, "rays of each operation");
        check_eq!(texels, expected_texels, "texels that {hit} rays read");
    }

    /// A surface is where its ray says, and as its records say: interpolated by the weights of the second and the third
    /// corner, coloured by the image and tilted by the bump map at the interpolated coordinates, in the level that the
    /// cone's width says; its normals are turned to the side from which the ray comes.
    #[
        "SH-2", not_for_kani "it is arithmetic in floating point",
        covers ["from the front", "from behind", "at the second corner", "at the third corner", "between them", "image", "bump map", "mirrored coordinates"]
    ]
    fn surface_is_what_its_records_say(s) {
        let features = features(s);
        let axis = s.value("axis of the normal", 0..=2, &WORDS[..3]) as usize;
        let mut normal = Vec3::ZERO;
        normal[axis] = if draw::flag(s, "normal upwards") { 1.0 } else { -1.0 };
        let direction = [Vec3::new(0.5, 0.25, -0.5), Vec3::new(-0.5, -0.5, 2.0)][usize::from(draw::flag(s, "direction"))];
        let (u, v) = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.25), (0.25, 0.5)][s.value("weights", 0..=4, &WORDS[..5]) as usize];
        let (t, begin) = (4.0_f32, [0.0_f32, 12.0][usize::from(draw::flag(s, "begins farther off"))]);
        let mirrored = draw::flag(s, "mirrored coordinates");
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut tangent = Vec3::ZERO;
        tangent[next] = 1.0;
        let mut across = Vec3::ZERO;
        across[last] = 0.75;
        let second = [[0.5, 0.25], [0.25, 0.5]][usize::from(mirrored)];
        let third = [[0.25, 0.5], [0.5, 0.25]][usize::from(mirrored)];
        let wanted = ShadingRecord {
            material: MATERIALS,
            normal,
            normals: [normal, normal * 0.5 + across, normal * 0.25 + tangent],
            tex_coords: [Vec2::new(0.125, 0.125), second.into(), third.into()],
            texture_density: 0.25,
            tangent,
        };
        let origin = Vec3::new(0.25, -8.0, 1.5);
        let record = |_: u32| wanted;
        let memory = || Observed::by_nobody(Records { features, record: &record, material: &material });
        let packet = Packet::new([Some(Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY })]);
        let hits = Hits::<1> { t: [t], u: [u], v: [v], triangle: [TRIANGLES.0] };
        let cones = Cones { spread: 1.0 / 64.0, begin: [begin] };
        let [found] = surfaces(&mut memory(), &registers(features), &packet, &hits, &cones);
        let Some(found) = found else {
            check!(false, "no surface where a ray hits a triangle");
            return Err(Stop::Vacuous);
        };
        let facing = normal.dot(direction);
        assume!(facing != 0.0);
        let front = facing < 0.0;
        cover!(s, "from the front", front);
        cover!(s, "from behind", !front);
        cover!(s, "at the second corner", u == 1.0);
        cover!(s, "at the third corner", v == 1.0);
        cover!(s, "between them", u == 0.5);
        cover!(s, "image", features.textures);
        cover!(s, "bump map", features.bump_maps);
        cover!(s, "mirrored coordinates", mirrored && features.bump_maps);
        let point = origin + direction * t;
        check_eq!((found.point, found.direction, found.distance, found.front), (point, direction, begin + t, front), "{wanted:?}");
        check_eq!(found.scale, origin.abs().max_element().max(point.abs().max_element()), "scale of {point}");
        check_eq!(found.plane_normal, if front { normal } else { -normal }, "plane's normal of {wanted:?}");
        let w = 1.0 - u - v;
        let uv = wanted.tex_coords[0] * w + wanted.tex_coords[1] * u + wanted.tex_coords[2] * v;
        let width = (begin + t) / 64.0 / facing;
        let area = width * width / 4.0;
        let stored = material(0);
        let colour = sample_colour(&mut memory(), IMAGE, uv, area);
        let diffuse = if features.textures { stored.diffuse * colour } else { stored.diffuse };
        check_eq!(found.diffuse, diffuse, "diffuse at {uv}, {area} of the square");
        let corners = if features.smooth_normals { wanted.normals } else { [normal; 3] }.map(Vec3::as_dvec3);
        let mut shading = (corners[0] * f64::from(w) + corners[1] * f64::from(u) + corners[2] * f64::from(v)).normalize();
        if features.bump_maps {
            let slope = sample_slope(&mut memory(), MAP, 2.0, uv, area).as_dvec2();
            let along = tangent.as_dvec3();
            let upwards = shading.cross(along) * if mirrored { -1.0 } else { 1.0 };
            shading = (shading - along * slope.x - upwards * slope.y).normalize();
        }
        if shading.dot(direction.as_dvec3()) >= 0.0 {
            shading = -shading;
        }
        check!(are_near(found.normal, shading), "normal {}, not {shading}: {wanted:?} at {u}, {v}", found.normal);
    }

    /// What a surface adds to its colour is Phong's: without lights and in the shadow by the angle to the viewer, in
    /// the light by the angle to the light, with a highlight where the mirrored ray meets it; a light behind the
    /// surface adds nothing.
    #[
        "SH-3", not_for_kani "it is arithmetic in floating point",
        covers ["lit", "behind the surface", "with a highlight", "beside the highlight", "seen from the side"]
    ]
    fn colours_are_phongs(s) {
        let (direction, normal) = (-unit(s, "to the viewer"), unit(s, "normal"));
        let facing = -f64::from(normal.dot(direction));
        assume!(facing >= -0.01);
        let (shininess, intensity) = (f32::from(s.value("shininess", 1..=9_u8, &[1, 2, 5])), 0.5);
        let surface = surface_of(direction, normal, true, plain(shininess, 1.0));
        let to_light = unit(s, "to the light");
        let light = Light { position: surface.point + to_light * 4.0, intensity };
        let diffuse = surface.diffuse.as_dvec3();
        let ambient = f64::from(AMBIENT);
        check!(are_near(surface.unlit(), diffuse * (ambient + (1.0 - ambient) * facing)), "unlit {surface:?}");
        check!(are_near(surface.ambient(), diffuse * (ambient * (1.0 + facing) / 2.0)), "ambient {surface:?}");
        check!((ambient - 0.3).abs() < 1.0e-7, "{ambient} of a surface's colour");
        let mirrored = direction.as_dvec3() + normal.as_dvec3() * (2.0 * facing);
        check!(are_near(surface.mirrored(), mirrored), "mirrored {surface:?}: {}", surface.mirrored());
        let cosine = f64::from(normal.dot(to_light));
        // Not where it is decided by rounding.
        assume!(cosine == 0.0 || cosine.abs() > 0.01);
        let glance = to_light.as_dvec3().dot(mirrored);
        cover!(s, "lit", cosine > 0.0);
        cover!(s, "behind the surface", cosine < 0.0);
        cover!(s, "with a highlight", cosine > 0.0 && glance > 0.5);
        cover!(s, "beside the highlight", cosine > 0.0 && glance < -0.1);
        cover!(s, "seen from the side", facing.abs() < 0.01);
        let shine = surface.material.specular.as_dvec3() * glance.max(0.0).powf(f64::from(shininess));
        let expected = if cosine > 0.0 { (diffuse * cosine + shine) * (0.7 * f64::from(intensity)) } else { DVec3::ZERO };
        check!(are_near(surface.lit(&light), expected), "lit by {light:?}: {surface:?} gives {}, not {expected}", surface.lit(&light));
    }

    /// A refracted ray obeys Snell's law, into the material from the front and out of it from behind, and is a unit
    /// vector; where all light is reflected it is the mirrored one.
    #[
        "RG-4", not_for_kani "it is arithmetic in floating point",
        covers ["into the material", "out of it", "all is reflected", "straight on", "the same index"]
    ]
    fn refraction_is_by_snells_law(s) {
        let (direction, normal) = (-unit(s, "to the viewer"), unit(s, "normal"));
        let cosine = -f64::from(normal.dot(direction));
        assume!(cosine > 0.01);
        let front = draw::flag(s, "front");
        let index = [1.0, 1.5, 2.0, 0.5][s.value("index of refraction", 0..=3, &WORDS[..4]) as usize];
        let surface = surface_of(direction, normal, front, plain(1.0, index as f32));
        let ratio: f64 = if front { 1.0 / index } else { index };
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let bent = ratio * sine;
        // Not where it is decided by rounding.
        assume!((bent - 1.0).abs() > 0.001);
        let found = surface.refracted();
        cover!(s, "into the material", front && index > 1.0 && sine > 0.1);
        cover!(s, "out of it", !front && index > 1.0 && sine > 0.1 && bent < 1.0);
        cover!(s, "all is reflected", bent > 1.0);
        cover!(s, "straight on", sine < 0.01);
        cover!(s, "the same index", index == 1.0);
        if bent > 1.0 {
            check_eq!(found, surface.mirrored(), "{surface:?}");
        } else {
            let (n, d) = (normal.as_dvec3(), direction.as_dvec3());
            let along = d + n * cosine;
            let expected = along * ratio - n * (1.0 - bent * bent).sqrt();
            check!(are_near(found, expected.normalize()), "{surface:?}: {found}, not {expected}");
            check!((f64::from(found.length()) - 1.0).abs() < 1.0e-6, "{surface:?}: {found} is no unit vector");
        }
    }
}
