//! The things that stand in the level.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};

use super::surfaces::Surfaces;
use crate::builtin::mesh::{Mesh, Surface, Vertex, circle};

/// The longest edge of a large flat part.
const COARSE: f32 = 100.0;

/// A pillar with base and capital, standing at `foot`.
pub fn pillar(mesh: &mut Mesh, s: &Surfaces, foot: Vec3, height: f32, radius: f32) {
    let sides = (6.0 + 12.0 * radius) as u32;
    let plinth = vec3(1.5 * radius, 0.3, 1.5 * radius);
    mesh.cuboid(s.trim, foot - plinth.with_y(0.0), foot + plinth, COARSE);
    let top = foot + Vec3::Y * (height - 0.3);
    mesh.cuboid(s.trim, top - plinth.with_y(0.0), top + plinth, COARSE);
    let profile = [
        (1.4, 0.3),
        (1.45, 0.4),
        (1.3, 0.5),
        (1.0, 0.62),
        (1.0, 0.25 * height),
        (0.95, 0.5 * height),
        (0.9, 0.75 * height),
        (0.88, height - 0.9),
        (1.0, height - 0.8),
        (1.0, height - 0.7),
        (1.2, height - 0.5),
        (1.4, height - 0.3),
    ];
    let mut shaft = Mesh::new(mesh.is_textured());
    shaft.lathe(s.pillar, &profile.map(|(r, y)| vec2(r * radius, y)), sides);
    mesh.append(&shaft, Affine3A::from_translation(foot));
}

/// The infill that rounds off the top of an opening `width` wide whose lintel's middle is at
/// `crown`, `depth` deep, across the horizontal unit vector `right`.
pub fn arch(mesh: &mut Mesh, surface: Surface, crown: Vec3, right: Vec3, width: f32, depth: f32) {
    const SEGMENTS: u32 = 14;
    let radius = width / 2.0;
    let through = right.cross(Vec3::Y) * depth / 2.0;
    let springing = crown - Vec3::Y * radius;
    // A point of the half circle, counter-clockwise from the right.
    let round = |u: f32| {
        let p = circle(u / 2.0) * radius;
        springing + right * p.x + Vec3::Y * p.y
    };
    for side in [through, -through] {
        mesh.patch(surface, [SEGMENTS, 1], |u, v| {
            let low = round(u);
            let position = low.lerp(low.with_y(crown.y), v) + side;
            let from_crown = position - crown;
            Vertex { position, along: vec2(from_crown.dot(right), from_crown.y) }
        });
    }
    mesh.patch(surface, [SEGMENTS, 1], |u, v| Vertex {
        position: round(u) + through * (1.0 - 2.0 * v),
        along: vec2(u * PI * radius, v * depth),
    });
}

/// A crate with a frame, a cube of side `size` turned by `angle`, standing at `foot`.
pub fn container(mesh: &mut Mesh, core: Surface, frame: Surface, foot: Vec3, size: f32, angle: f32) {
    let mut crate_ = Mesh::new(mesh.is_textured());
    let half = size / 2.0;
    let inner = half * 0.94;
    let bar = size * 0.12;
    crate_.cuboid(core, vec3(-inner, 0.03 * size, -inner), vec3(inner, 0.97 * size, inner), COARSE);
    let corner = [-half, half - bar];
    for x in corner {
        for z in corner {
            crate_.cuboid(frame, vec3(x, 0.0, z), vec3(x + bar, size, z + bar), COARSE);
        }
    }
    for y in [0.0, size - bar] {
        for at in corner {
            let inside = half - bar;
            crate_.cuboid(frame, vec3(-inside, y, at), vec3(inside, y + bar, at + bar), COARSE);
            crate_.cuboid(frame, vec3(at, y, -inside), vec3(at + bar, y + bar, inside), COARSE);
        }
    }
    mesh.append(&crate_, turned(foot, angle));
}

/// A pipe through `points`, rounded at the bends, with flanges.
pub fn pipe(mesh: &mut Mesh, s: &Surfaces, surface: Surface, points: &[Vec3], radius: f32) {
    const BEND_STEPS: u32 = 4;
    let bend = 3.0 * radius;
    let mut line = vec![points[0]];
    for bent in points.windows(3) {
        let [from, corner, to] = [bent[0], bent[1], bent[2]];
        let (a, b) = (corner + (from - corner).normalize() * bend, corner + (to - corner).normalize() * bend);
        // A quadratic Bezier curve rounds the corner.
        line.extend((0..=BEND_STEPS).map(|i| {
            let t = i as f32 / BEND_STEPS as f32;
            a.lerp(corner, t).lerp(corner.lerp(b, t), t)
        }));
    }
    line.push(points[points.len() - 1]);
    mesh.tube(surface, &line, radius, 9);
    for run in points.windows(2) {
        let dir = (run[1] - run[0]).normalize();
        let flanges = (run[0].distance(run[1]) / 3.0) as u32;
        for i in 1..=flanges {
            let at = run[0].lerp(run[1], i as f32 / (flanges + 1) as f32);
            let ends = [(at - dir * 0.06, 1.35 * radius), (at + dir * 0.06, 1.35 * radius)];
            mesh.closed_cylinder(s.steel, ends, 9, 1);
        }
    }
}

/// A grate of `bars` bars in each direction over the rectangle `right × front` at `origin`, in the
/// plane of the two.
pub fn grate(mesh: &mut Mesh, surface: Surface, origin: Vec3, right: Vec3, front: Vec3, bars: u32) {
    let sunk = right.cross(front).normalize() * 0.03;
    for (along, across, sink) in [(right, front, Vec3::ZERO), (front, right, sunk)] {
        for i in 0..bars {
            let at = origin + across * ((i as f32 + 0.5) / bars as f32) + sink;
            mesh.closed_cylinder(surface, [(at, 0.03), (at + along, 0.03)], 5, 1);
        }
    }
}

/// A pew that runs `along` a horizontal line from `foot`, its back towards less x.
pub fn pew(mesh: &mut Mesh, s: &Surfaces, foot: Vec3, along: Vec3) {
    let board = |mesh: &mut Mesh, from: Vec3, to: Vec3, along: Vec3| {
        mesh.cuboid(s.crate_wood, foot + from, foot + to + along, COARSE);
    };
    board(mesh, vec3(0.0, 0.42, 0.0), vec3(0.45, 0.47, 0.0), along);
    for height in [0.55, 0.75, 0.95] {
        board(mesh, vec3(-0.05, height, 0.0), vec3(0.0, height + 0.12, 0.0), along);
    }
    for end in [Vec3::ZERO, along] {
        board(mesh, end + vec3(-0.1, 0.0, -0.05), end + vec3(0.45, 1.1, 0.05), Vec3::ZERO);
    }
}

/// A flight of `steps` steps that rises `rise` along the horizontal `run`, `across` wide.
pub fn stairs(mesh: &mut Mesh, s: &Surfaces, foot: Vec3, run: Vec3, across: Vec3, rise: f32, steps: u32) {
    let (tread, riser) = (run / steps as f32, Vec3::Y * rise / steps as f32);
    for i in 0..steps {
        let at = foot + (tread + riser) * i as f32;
        mesh.quad(s.trim, at, across, riser, 2.0);
        mesh.quad(s.tread, at + riser, across, tread, 2.0);
    }
}

/// A banner that hangs from `top` and waves, `right` wide and `drop` long.
pub fn banner(mesh: &mut Mesh, s: &Surfaces, top: Vec3, right: Vec3, drop: f32) {
    let out = right.cross(Vec3::Y).normalize();
    let width = right.length();
    mesh.patch(s.banner, [6, 12], |u, v| {
        let down = 1.0 - v;
        let wave = 0.12 * down * (libm::sinf(TAU * (u + 0.7 * down)) + 1.0);
        Vertex {
            position: top + right * u - Vec3::Y * drop * down + out * wave,
            along: vec2(u * width, v * drop),
        }
    });
    let pole = [(top - right * 0.1, 0.04), (top + right * 1.1, 0.04)];
    mesh.closed_cylinder(s.gold, pole, 8, 1);
}

/// A lamp on a rod that hangs from `hook`, `drop` long.
pub fn lamp(mesh: &mut Mesh, s: &Surfaces, hook: Vec3, drop: f32) {
    mesh.cylinder(s.grate, [(hook - Vec3::Y * drop, 0.03), (hook, 0.03)], 8, 4);
    let mut shade = Mesh::new(mesh.is_textured());
    let profile = [(0.05, -0.25), (0.3, -0.3), (0.32, -0.25), (0.2, 0.0), (0.08, 0.1), (0.0, 0.12)];
    shade.lathe(s.gold, &profile.map(|(r, y)| vec2(r, y)), 10);
    shade.sphere(s.yellow_item, vec3(0.0, -0.25, 0.0), 0.14, 10, 6);
    mesh.append(&shade, Affine3A::from_translation(hook - Vec3::Y * drop));
}

/// A player of 1.8 m in armour with a weapon, standing at `foot` and looking to `angle`.
pub fn player(mesh: &mut Mesh, s: &Surfaces, armour: Surface, foot: Vec3, angle: f32) {
    let mut body = Mesh::new(mesh.is_textured());
    let torso = [
        (0.0, 0.84),
        (0.17, 0.86),
        (0.19, 0.95),
        (0.16, 1.08),
        (0.19, 1.22),
        (0.24, 1.36),
        (0.22, 1.46),
        (0.1, 1.52),
        (0.07, 1.58),
    ];
    body.lathe(armour, &torso.map(|(r, y)| vec2(r, y)), 16);
    body.sphere(s.skin, vec3(0.0, 1.68, 0.0), 0.12, 16, 10);
    body.torus(s.steel, vec3(0.0, 1.7, 0.0), Quat::from_rotation_x(PI / 2.0), [0.12, 0.025], [16, 6]);
    for side in [-1.0, 1.0] {
        let at = |x: f32, y: f32, z: f32| vec3(side * x, y, z);
        body.sphere(armour, at(0.27, 1.42, 0.0), 0.12, 12, 7);
        let [shoulder, elbow, hand] = [at(0.28, 1.38, 0.0), at(0.32, 1.12, 0.05), at(0.18, 1.1, 0.34)];
        body.closed_cylinder(s.skin, [(shoulder, 0.07), (elbow, 0.055)], 10, 3);
        body.sphere(s.steel, elbow, 0.07, 10, 6);
        body.closed_cylinder(armour, [(elbow, 0.06), (hand, 0.045)], 10, 3);
        body.sphere(s.skin, hand, 0.055, 8, 6);
        let [hip, knee, ankle] = [at(0.1, 0.9, 0.0), at(0.13, 0.5, 0.05), at(0.14, 0.1, -0.03)];
        body.closed_cylinder(armour, [(hip, 0.11), (knee, 0.08)], 12, 4);
        body.sphere(s.steel, knee, 0.09, 10, 6);
        body.closed_cylinder(s.skin, [(knee, 0.075), (ankle, 0.055)], 10, 4);
        body.cuboid(
            s.weapon,
            at(0.14, 0.05, 0.05) - vec3(0.06, 0.05, 0.14),
            at(0.14, 0.05, 0.05) + vec3(0.06, 0.05, 0.14),
            0.1,
        );
    }
    weapon(&mut body, s, Affine3A::from_translation(vec3(0.12, 1.12, 0.4)));
    mesh.append(&body, turned(foot, angle));
}

/// A weapon of half a metre along z.
pub fn weapon(mesh: &mut Mesh, s: &Surfaces, transform: Affine3A) {
    let mut gun = Mesh::new(mesh.is_textured());
    gun.cuboid(s.weapon, vec3(-0.04, -0.06, -0.25), vec3(0.04, 0.06, 0.1), 0.12);
    gun.cuboid(s.weapon, vec3(-0.02, -0.18, -0.2), vec3(0.02, -0.06, -0.12), COARSE);
    for i in 0..6 {
        let turn = circle(i as f32 / 6.0) * 0.03;
        let barrel = |z: f32| (vec3(turn.x, turn.y, z), 0.013);
        gun.closed_cylinder(s.steel, [barrel(0.1), barrel(0.45)], 6, 1);
    }
    gun.torus(s.gold, vec3(0.0, 0.0, 0.3), Quat::IDENTITY, [0.045, 0.012], [12, 5]);
    mesh.append(&gun, transform);
}

/// The kinds of item that lie in the level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// A weapon, standing on its edge.
    Weapon,
    /// A ball in two rings.
    Health,
    /// A breastplate.
    Armour,
    /// A box of ammunition.
    Ammunition,
}

/// An item that floats over its pedestal at `foot`.
pub fn item(mesh: &mut Mesh, s: &Surfaces, kind: Item, foot: Vec3, angle: f32) {
    mesh.closed_cylinder(s.trim, [(foot, 0.5), (foot + Vec3::Y * 0.15, 0.4)], 16, 1);
    let at = foot + Vec3::Y * 0.7;
    match kind {
        Item::Weapon => weapon(mesh, s, turned(at, angle)),
        Item::Health => {
            mesh.sphere(s.green_item, at, 0.18, 16, 9);
            for tilt in [-0.5, 0.5] {
                let turn = Quat::from_rotation_y(angle) * Quat::from_rotation_x(PI / 2.0 + tilt);
                mesh.torus(s.gold, at, turn, [0.26, 0.025], [18, 5]);
            }
        }
        Item::Armour => {
            let mut plate = Mesh::new(mesh.is_textured());
            let profile = [(0.14, -0.2), (0.17, -0.1), (0.2, 0.05), (0.24, 0.18), (0.2, 0.26), (0.1, 0.28)];
            plate.lathe(s.red_armour, &profile.map(|(r, y)| vec2(r, y)), 16);
            for side in [-1.0, 1.0] {
                plate.sphere(s.yellow_item, vec3(0.24 * side, 0.18, 0.0), 0.1, 10, 6);
            }
            mesh.append(&plate, turned(at, angle));
        }
        Item::Ammunition => {
            container(mesh, s.yellow_item, s.weapon, foot + Vec3::Y * 0.3, 0.35, angle);
        }
    }
}

/// A tank with domed ends and hoops, `height` high and standing upright at `foot`.
pub fn tank(mesh: &mut Mesh, s: &Surfaces, foot: Vec3, radius: f32, height: f32) {
    const DOME_STEPS: u32 = 5;
    let dome = radius * 0.5;
    // A quarter of an ellipse from the axis outwards.
    let quarter = |i: u32| {
        let p = circle(0.25 * (1.0 - i as f32 / DOME_STEPS as f32));
        vec2(if i == 0 { 0.0 } else { p.x * radius }, p.y * dome)
    };
    let bottom = (0..=DOME_STEPS).map(|i| vec2(quarter(i).x, dome - quarter(i).y));
    let top = (0..=DOME_STEPS).rev().map(|i| vec2(quarter(i).x, height - dome + quarter(i).y));
    let profile: Vec<Vec2> = bottom.chain(top).collect();
    let mut body = Mesh::new(mesh.is_textured());
    body.lathe(s.machine, &profile, 18);
    mesh.append(&body, Affine3A::from_translation(foot));
    for part in [0.35, 0.65] {
        let turn = Quat::from_rotation_x(PI / 2.0);
        mesh.torus(s.grate, foot + Vec3::Y * height * part, turn, [radius, 0.06], [18, 4]);
    }
}

/// A move to `foot` after a turn by `angle` about the y axis.
fn turned(foot: Vec3, angle: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), foot)
}
