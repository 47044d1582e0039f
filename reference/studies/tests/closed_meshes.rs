//! Closed meshes from inside: every ray has to leave through the mesh, whatever it is aimed at. A ray
//! that hits nothing has leaked between two triangles.
//!
//! Rays are aimed at vertices, at edges, at points of triangles, and along an axis at vertices, so
//! that they meet them exactly and edge functions are 0. Each goes through the chip's kd-tree with each
//! triangle test, and some also to each test in each number format, with the triangles that the
//! reference's hierarchy leaves around it.

use glam::Vec3;
use rayon::prelude::*;
use saarcor_model::host::{Edges, HostImage, Kernel, Material, Scene, Triangle};
use saarcor_model::rays::{Query, Ray};
use saarcor_oracles::bvh::Bvh;
use saarcor_scenes::Random;
use saarcor_scenes::kdbuild::{BuildOptions, build};
use saarcor_studies::accuracy::case::Case;
use saarcor_studies::accuracy::contest::{Contestant, Format};
use saarcor_studies::crosscheck::rays::traverse;
use std::collections::HashMap;

/// Rays a mesh and place, by default and in the long test.
const FEW: usize = 1 << 13;
const MANY: usize = 1 << 20;

/// One ray of so many also goes to each number format.
const IN_ALL_FORMATS: usize = 16;

/// A closed mesh, and points inside of it.
struct Mesh {
    name: &'static str,
    triangles: Vec<[Vec3; 3]>,
    inside: fn(&mut Random) -> Vec3,
    /// From a vertex, a point inside that differs from it in one coordinate, where there is one.
    beside: fn(Vec3) -> Option<Vec3>,
}

/// An icosahedron whose triangles are split in four as often as said, with all vertices on the unit sphere.
fn icosphere(splits: u32) -> Vec<[Vec3; 3]> {
    let golden = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut corners = Vec::new();
    for (x, y) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        corners.extend([Vec3::new(x, y, 0.0), Vec3::new(0.0, x, y), Vec3::new(y, 0.0, x)]);
    }
    // An edge is as long as the nearest vertices are apart, 2; a triangle has three.
    let is_edge = |a: usize, b: usize| ((corners[a] - corners[b]).length() - 2.0).abs() < 1e-3;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b) && is_edge(b, c) && is_edge(a, c) {
                    triangles.push([a, b, c].map(|corner| corners[corner].normalize()));
                }
            }
        }
    }
    for _ in 0..splits {
        // The same from either end.
        let middle = |a: Vec3, b: Vec3| (a + b).normalize();
        let split = |[a, b, c]: [Vec3; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    triangles
}

fn near_the_centre(random: &mut Random) -> Vec3 {
    Vec3::new(random.between(-0.3, 0.3), random.between(-0.3, 0.3), random.between(-0.3, 0.3))
}

/// Inside of spheres: the largest coordinate makes up a third of the square of the distance at least.
fn towards_the_centre(vertex: Vec3) -> Option<Vec3> {
    let mut point = vertex;
    point[vertex.abs().max_position()] *= 0.25;
    Some(point)
}

fn sphere() -> Mesh {
    Mesh { name: "sphere", triangles: icosphere(5), inside: near_the_centre, beside: towards_the_centre }
}

/// The sphere with vertices moved in and out by a twentieth, as noise of a scanner would.
fn scan() -> Mesh {
    let moved = |vertex: Vec3| {
        let seed =
            vertex.to_array().iter().fold(0, |hash, x| Random::new(hash ^ u64::from(x.to_bits())).bits());
        vertex * Random::new(seed).between(0.95, 1.05)
    };
    let triangles = icosphere(5).into_iter().map(|corners| corners.map(moved)).collect();
    Mesh { name: "scan", triangles, ..sphere() }
}

/// Squares of a torus around and along its tube, of radius 1 around a circle of radius 3.
fn torus() -> Mesh {
    const CELLS: [u32; 2] = [128, 64];
    let turn = |i: u32, of: u32| ((i % of) as f32 / of as f32 * std::f32::consts::TAU).sin_cos();
    let vertex = |i: u32, j: u32| {
        let ((sin, cos), (y, out)) = (turn(i, CELLS[0]), turn(j, CELLS[1]));
        Vec3::new(cos * (3.0 + out), y, sin * (3.0 + out))
    };
    let square = |(i, j): (u32, u32)| {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let squares = (0..CELLS[0]).flat_map(|i| (0..CELLS[1]).map(move |j| (i, j)));
    Mesh {
        name: "torus",
        triangles: squares.flat_map(square).collect(),
        inside: |random| {
            let (sin, cos) = random.between(0.0, std::f32::consts::TAU).sin_cos();
            Vec3::new(cos, 0.0, sin) * 3.0 + near_the_centre(random)
        },
        // Straight up and down, from the plane of the circle.
        beside: |vertex| (vertex.y.abs() > 0.1).then_some(vertex * Vec3::new(1.0, 0.0, 1.0)),
    }
}

impl Mesh {
    /// A ray of one of four ideas, within the mesh moved to `place`.
    fn ray(&self, place: Vec3, random: &mut Random) -> Ray {
        let triangle = self.triangles[random.range(0, self.triangles.len() as u32) as usize];
        let [a, b, c] = triangle.map(|corner| corner + place);
        let along = random.unit();
        let origin = (self.inside)(random) + place;
        let towards = |target: Vec3| (origin, target - origin);
        let (origin, direction) = match random.range(0, 8) {
            0..3 => towards(a),
            3..6 => towards(a + (b - a) * along),
            6 => towards((a + b + c) / 3.0),
            _ => match (self.beside)(triangle[0]) {
                // One coordinate differs, and the others of the direction are 0.
                Some(beside) => (beside + place, a - (beside + place)),
                None => towards(a),
            },
        };
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The leaks of each triangle test in the kd-tree, by the order of [`Kernel::ALL`], and of each in each format,
    /// of so many rays.
    fn leaks(&self, place: Vec3, count: usize) -> (Vec<usize>, HashMap<Contestant, usize>) {
        let corners: Vec<_> = self.triangles.iter().map(|it| it.map(|corner| corner + place)).collect();
        let triangles = corners.iter().map(|&corners| Triangle { corners, material: 0 }).collect();
        let scene = Scene { triangles, materials: vec![Material::default()], ..Scene::default() };
        let tree = build(&scene.triangles, &BuildOptions::default(), &|_| {});
        let ray = |number: usize| self.ray(place, &mut Random::new(Random::new(number as u64).bits()));
        let rays: Vec<Ray> = (0..count).map(ray).collect();
        let in_tree = |kernel| {
            let image = HostImage::build(&scene, &tree, kernel).expect("a valid tree").into();
            traverse(&image, &rays, Query::Closest).into_iter().filter(Option::is_none).count()
        };
        // Half as large again: a test that rounds may find a ray in a triangle beside the one that it meets.
        let enlarged = |&[a, b, c]: &[Vec3; 3]| {
            let centre = (a + b + c) / 3.0;
            [a, b, c].map(|corner| centre + (corner - centre) * 1.5)
        };
        let bvh = Bvh::new(&corners.iter().map(enlarged).collect::<Vec<_>>());
        let case = |ray: &Ray| {
            let near = bvh.candidates(ray, f64::INFINITY).map(|number| corners[number as usize]);
            Case { ray: *ray, triangles: near.collect() }
        };
        let cases: Vec<Case> = rays.par_iter().step_by(IN_ALL_FORMATS).map(case).collect();
        let in_format = |contestant: Contestant| {
            let lost = contestant.run(&cases, Edges::Shared, 1).0.into_iter().filter(Option::is_none).count();
            (contestant, lost)
        };
        let kernels = Kernel::ALL.into_iter().map(in_tree).collect();
        (kernels, Contestant::all().into_par_iter().map(in_format).collect())
    }
}

fn every_ray_leaves_through(mesh: &Mesh, rays: usize) {
    // Far from the origin coordinates have fewer bits.
    for place in [Vec3::ZERO, Vec3::new(1000.0, -1000.0, 1000.0)] {
        let (in_tree, in_formats) = mesh.leaks(place, rays);
        let name = format!("{} at {}", mesh.name, place.x);
        let in_tree = |kernel| in_tree[kernel as usize];
        let of = |kernel, format| in_formats[&Contestant { kernel, format }];
        println!("{name}: {} triangles, {rays} rays", mesh.triangles.len());
        for kernel in Kernel::ALL {
            let formats = Format::ALL
                .into_iter()
                .filter(|&format| in_formats.contains_key(&Contestant { kernel, format }));
            let leaks: Vec<_> = formats.map(|format| (format.name(), of(kernel, format))).collect();
            println!("  {kernel:?}: {} leaks; of {} rays {leaks:?}", in_tree(kernel), rays / IN_ALL_FORMATS);
        }
        assert_eq!((in_tree(Kernel::Adaptive), of(Kernel::Adaptive, Format::F32)), (0, 0), "{name}");
        assert_eq!(in_tree(Kernel::Watertight), 0, "{name}");
        for format in [Format::F64, Format::F32] {
            assert_eq!(of(Kernel::Watertight, format), 0, "{name}, {}", format.name());
        }
        // The rays see a fault where there is one.
        assert!(in_tree(Kernel::MollerTrumbore) > 0 && in_tree(Kernel::Wald) > 0, "{name}");
    }
}

#[test]
fn every_ray_leaves() {
    [sphere(), scan(), torus()].iter().for_each(|mesh| every_ray_leaves_through(mesh, FEW));
}

#[test]
#[ignore = "long: 2^20 rays with each triangle test, twice"]
fn a_million_rays_leave_a_scanned_mesh() {
    every_ray_leaves_through(&scan(), MANY);
}
