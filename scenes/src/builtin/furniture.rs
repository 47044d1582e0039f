//! Furniture: each piece a mesh that stands on y = 0 around the origin and faces along +z, in metres.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};

use super::finish::Finish;
use super::mesh::{Mesh, Vertex, rounded_line};
use saarcor_random::Random;

/// A cell size that leaves faces whole.
pub const WHOLE: f32 = f32::INFINITY;

/// An untextured empty mesh.
#[must_use]
pub fn empty() -> Mesh {
    Mesh::new(false)
}

/// Adds a box with whole faces.
pub fn block(mesh: &mut Mesh, finish: Finish, min: Vec3, max: Vec3) {
    mesh.cuboid(finish.surface(), min, max, WHOLE);
}

/// The transform that turns by `turns` about the y axis and then moves to `to`.
#[must_use]
pub fn placed(to: Vec3, turns: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(turns * TAU), to)
}

/// The closed line along the edge of a rectangle in a plane of constant y, its corners rounded.
fn rim(half: Vec2, y: f32, radius: f32, cells: u32) -> Vec<Vec3> {
    let start = vec3(0.0, y, -half.y);
    let corners = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let mut points = vec![start];
    points.extend(corners.map(|(x, z)| vec3(x * half.x, y, z * half.y)));
    points.push(start);
    rounded_line(&points, radius, cells)
}

/// An upholstered armchair on a sled of bent tube: soft seat and back with piping, padded arms.
#[must_use]
pub fn armchair(fabric: Finish) -> Mesh {
    let mut chair = empty();
    let (cloth, steel) = (fabric.surface(), Finish::Steel.surface());

    let mut seat = empty();
    seat.rounded_cuboid(cloth, [vec3(-0.25, 0.40, -0.24), vec3(0.25, 0.47, 0.25)], 0.03, 3, [7, 1, 7]);
    seat.tube(cloth, &rim(vec2(0.247, 0.237), 0.462, 0.04, 6), 0.005, 8);
    let swell = |x: f32| 1.0 - (x / 0.25).powi(2);
    let seat = seat.bent(|p| {
        let top = if p.y > 0.435 { 0.02 } else { 0.0 };
        p + Vec3::Y * top * swell(p.x).max(0.0) * swell(p.z).max(0.0)
    });
    chair.append(&seat, Affine3A::IDENTITY);

    let mut back = empty();
    back.rounded_cuboid(cloth, [vec3(-0.24, 0.50, -0.03), vec3(0.24, 0.96, 0.03)], 0.025, 3, [8, 6, 1]);
    let piping: Vec<Vec3> =
        rim(vec2(0.236, 0.226), 0.024, 0.04, 6).iter().map(|p| vec3(p.x, 0.73 + p.z, p.y)).collect();
    back.tube(cloth, &piping, 0.005, 8);
    // Hollow towards the sitter, and leaning back.
    let back = back.bent(|p| p + Vec3::Z * (0.9 * p.x * p.x - 0.22 - 0.22 * (p.y - 0.5)));
    chair.append(&back, Affine3A::IDENTITY);

    for side in [-1.0, 1.0] {
        let at = |y: f32, z: f32| vec3(side * 0.275, y, z);
        let sled = [
            at(0.3, 0.24),
            at(0.65, 0.22),
            at(0.65, -0.27),
            at(0.012, -0.30),
            at(0.012, 0.26),
            at(0.3, 0.24),
        ];
        chair.tube(steel, &rounded_line(&sled, 0.07, 6), 0.012, 8);
        let arm = [vec3(side * 0.275 - 0.025, 0.66, -0.18), vec3(side * 0.275 + 0.025, 0.69, 0.18)];
        chair.rounded_cuboid(Finish::PlasticBlack.surface(), arm, 0.012, 2, [1, 1, 3]);
        // The strut from the sled up the back, and screws where it holds.
        let strut = [at(0.62, -0.265), at(0.70, -0.29), vec3(side * 0.20, 0.78, -0.30)];
        chair.tube(steel, &rounded_line(&strut, 0.05, 6), 0.008, 8);
        for z in [-0.14, 0.14] {
            let head = vec3(side * 0.254, 0.43, z);
            let screw = [(head, 0.009), (head + Vec3::X * side * 0.012, 0.006)];
            chair.closed_cylinder(Finish::Brass.surface(), screw, 10, 1);
        }
    }
    for z in [-0.16, 0.16] {
        let bar = [(vec3(-0.275, 0.39, z), 0.009), (vec3(0.275, 0.39, z), 0.009)];
        chair.cylinder(steel, bar, 10, 1);
        for side in [-1.0, 1.0] {
            let knee = [
                vec3(side * 0.268, 0.39, z),
                vec3(side * 0.272, 0.30, z * 1.3),
                vec3(side * 0.272, 0.024, z * 1.4),
            ];
            chair.tube(steel, &rounded_line(&knee, 0.06, 5), 0.006, 8);
        }
    }
    chair
}

/// A light stacking chair: a thin pad and back on four bent legs, with or without arms.
#[must_use]
pub fn side_chair(fabric: Finish, arms: bool) -> Mesh {
    let mut chair = empty();
    let steel = Finish::Steel.surface();
    let seat = [vec3(-0.22, 0.43, -0.21), vec3(0.22, 0.46, 0.22)];
    chair.rounded_cuboid(fabric.surface(), seat, 0.014, 2, [3, 1, 3]);
    let mut back = empty();
    back.rounded_cuboid(
        fabric.surface(),
        [vec3(-0.21, 0.62, -0.012), vec3(0.21, 0.88, 0.012)],
        0.011,
        2,
        [6, 2, 1],
    );
    let back = back.bent(|p| p + Vec3::Z * (0.7 * p.x * p.x - 0.25 - 0.15 * (p.y - 0.6)));
    chair.append(&back, Affine3A::IDENTITY);
    for side in [-1.0, 1.0] {
        let at = |y: f32, z: f32| vec3(side * 0.235, y, z);
        let front = [at(0.0, 0.24), at(0.42, 0.20), at(0.42, -0.19), at(0.86, -0.275)];
        chair.tube(steel, &rounded_line(&front, 0.06, 6), 0.010, 7);
        chair.tube(steel, &rounded_line(&[at(0.40, 0.0), at(0.36, -0.1), at(0.0, -0.30)], 0.08, 6), 0.010, 7);
        for z in [0.24, -0.30] {
            let glide = [(at(0.0, z), 0.016), (at(0.02, z), 0.012)];
            chair.closed_cylinder(Finish::PlasticBlack.surface(), glide, 8, 1);
        }
        for y in [0.66, 0.84] {
            let lug = [(at(y, -0.235 - 0.19 * (y - 0.42)), 0.007), (vec3(side * 0.2, y, -0.235), 0.007)];
            chair.cylinder(steel, lug, 6, 1);
        }
        if arms {
            let arm = [at(0.42, 0.17), at(0.66, 0.16), at(0.67, -0.20), at(0.64, -0.23)];
            chair.tube(steel, &rounded_line(&arm, 0.05, 6), 0.008, 8);
            let pad = [vec3(side * 0.235 - 0.02, 0.665, -0.16), vec3(side * 0.235 + 0.02, 0.685, 0.12)];
            chair.rounded_cuboid(Finish::DarkWood.surface(), pad, 0.008, 2, [1, 1, 3]);
        }
    }
    for z in [-0.17, 0.18] {
        chair.cylinder(steel, [(vec3(-0.235, 0.42, z), 0.008), (vec3(0.235, 0.42, z), 0.008)], 8, 1);
    }
    chair
}

/// A wooden chair: turned legs, a flat seat, and a back of slats.
#[must_use]
pub fn wooden_chair() -> Mesh {
    let mut chair = empty();
    let wood = Finish::Wood;
    block(&mut chair, wood, vec3(-0.20, 0.43, -0.20), vec3(0.20, 0.455, 0.21));
    for side in [-1.0, 1.0] {
        let leg = |z: f32| [(vec3(side * 0.19, 0.0, z * 1.1), 0.012), (vec3(side * 0.17, 0.43, z), 0.018)];
        chair.cylinder(wood.surface(), leg(0.17), 8, 1);
        chair.cylinder(wood.surface(), leg(-0.17), 8, 1);
        let post = [(vec3(side * 0.18, 0.455, -0.18), 0.016), (vec3(side * 0.18, 0.90, -0.26), 0.013)];
        chair.closed_cylinder(wood.surface(), post, 8, 1);
    }
    for i in 0..3 {
        let (y, z) = (0.58 + 0.12 * i as f32, -0.205 - 0.0215 * i as f32);
        block(&mut chair, wood, vec3(-0.166, y, z - 0.006), vec3(0.166, y + 0.05, z + 0.006));
    }
    chair
}

/// A swivel chair on five castors.
#[must_use]
pub fn swivel_chair(fabric: Finish) -> Mesh {
    let mut chair = empty();
    let (cloth, plastic) = (fabric.surface(), Finish::PlasticBlack.surface());
    chair.rounded_cuboid(cloth, [vec3(-0.24, 0.44, -0.23), vec3(0.24, 0.52, 0.24)], 0.035, 1, [1, 1, 1]);
    let mut back = empty();
    back.rounded_cuboid(cloth, [vec3(-0.21, 0.62, -0.03), vec3(0.21, 1.02, 0.03)], 0.028, 1, [3, 2, 1]);
    let back = back.bent(|p| p + Vec3::Z * (0.8 * p.x * p.x - 0.24 - 0.1 * (p.y - 0.6)));
    chair.append(&back, Affine3A::IDENTITY);
    let spine = [vec3(0.0, 0.43, -0.1), vec3(0.0, 0.43, -0.30), vec3(0.0, 0.75, -0.29)];
    chair.tube(plastic, &rounded_line(&spine, 0.08, 3), 0.018, 6);
    chair.cylinder(Finish::Steel.surface(), [(Vec3::Y * 0.10, 0.03), (Vec3::Y * 0.44, 0.025)], 10, 1);
    for leg in 0..5 {
        let turn = placed(Vec3::ZERO, leg as f32 / 5.0);
        let mut foot = empty();
        foot.closed_cylinder(plastic, [(vec3(0.0, 0.11, 0.02), 0.03), (vec3(0.0, 0.075, 0.28), 0.016)], 6, 1);
        let hub = |x: f32| (vec3(x, 0.028, 0.28), 0.027);
        foot.closed_cylinder(plastic, [hub(-0.02), hub(0.02)], 8, 1);
        chair.append(&foot, turn);
    }
    chair
}

/// A long table for meetings with round ends, `length` along x, its top at 0.74 and of the finish `top` inside an inlaid frame.
#[must_use]
pub fn meeting_table(length: f32, width: f32, top: Finish) -> Mesh {
    const ARC: u32 = 32;
    let mut table = empty();
    let straight = length / 2.0 - width / 2.0;
    // The point of a half circle around one end, u from 0 to 1; `from` is 0 at +x, half a turn at -x.
    let end = |from: f32, u: f32, inset: f32| {
        let turn = TAU * (from + 0.5 * u - 0.25);
        let radius = width / 2.0 - inset;
        let x = if from == 0.0 { straight } else { -straight };
        vec2(x + libm::cosf(turn) * radius, -libm::sinf(turn) * radius)
    };
    // A band all around; each step from its lower or outer edge is an inset and a height.
    let band = |steps: &[(f32, f32)], finish: Finish, table: &mut Mesh| {
        let cells = steps.len() as u32 - 1;
        let step = |v: f32| steps[(v * cells as f32).round() as usize];
        for from in [0.0, 0.5] {
            table.patch(finish.surface(), [ARC, cells], |u, v| {
                let (inset, y) = step(v);
                let p = end(from, u, inset);
                Vertex { position: vec3(p.x, y, p.y), along: p }
            });
            table.patch(finish.surface(), [8, cells], |u, v| {
                let (inset, y) = step(v);
                let p = end(from, 1.0, inset).lerp(end(0.5 - from, 0.0, inset), u);
                Vertex { position: vec3(p.x, y, p.y), along: p }
            });
        }
    };
    let edge = [(0.05, 0.700), (0.012, 0.702), (0.0, 0.712), (0.0, 0.728), (0.004, 0.736), (0.012, 0.74)];
    band(&edge, Finish::DarkWood, &mut table);
    // An inlaid frame around the field.
    band(&[(0.012, 0.74), (0.10, 0.74)], Finish::DarkWood, &mut table);
    band(&[(0.10, 0.74), (0.106, 0.74)], Finish::Brass, &mut table);
    let field = top.surface();
    let inner = width / 2.0 - 0.106;
    let side = Vec3::X * 2.0 * straight;
    table.quad(field, vec3(-straight, 0.74, inner), side, Vec3::NEG_Z * 2.0 * inner, WHOLE);
    for (from, x) in [(0.0, straight), (0.5, -straight)] {
        table.patch(field, [ARC, 1], |u, v| {
            let p = end(from, u, 0.106).lerp(vec2(x, 0.0), v);
            Vertex { position: vec3(p.x, 0.74, p.y), along: p }
        });
    }
    for x in [-straight, 0.0, straight] {
        let column =
            [vec2(0.30, 0.0), vec2(0.30, 0.03), vec2(0.26, 0.05), vec2(0.09, 0.09), vec2(0.075, 0.14)];
        let capital = [vec2(0.075, 0.60), vec2(0.10, 0.66), vec2(0.22, 0.69), vec2(0.22, 0.70)];
        let mut leg = empty();
        leg.lathe(Finish::DarkWood.surface(), &[&column[..], &capital[..]].concat(), 32);
        table.append(&leg, placed(vec3(x, 0.0, 0.0), 0.0));
    }
    table
}

/// A desk with a drawer pedestal on its right, its top at 0.74, the sitter at +z.
#[must_use]
pub fn desk(width: f32, depth: f32, top: Finish) -> Mesh {
    let mut desk = empty();
    let (x, z) = (width / 2.0, depth / 2.0);
    desk.rounded_cuboid(top.surface(), [vec3(-x, 0.71, -z), vec3(x, 0.74, z)], 0.01, 1, [1, 1, 1]);
    block(&mut desk, Finish::PlasticGrey, vec3(-x + 0.05, 0.30, -z + 0.04), vec3(x - 0.05, 0.70, -z + 0.06));
    for (px, pz) in [(-x + 0.05, z - 0.05), (-x + 0.05, -z + 0.05), (x - 0.05, -z + 0.05)] {
        let leg = [(vec3(px, 0.0, pz), 0.022), (vec3(px, 0.71, pz), 0.022)];
        desk.cylinder(Finish::Steel.surface(), leg, 8, 1);
    }
    desk.append(&drawers(0.40, 0.62, 3, top), placed(vec3(x - 0.26, 0.06, z - 0.32), 0.0));
    desk
}

/// A stack of drawers `width` wide and `height` high, 0.56 deep, with handles.
#[must_use]
pub fn drawers(width: f32, height: f32, count: u32, front: Finish) -> Mesh {
    let mut stack = empty();
    let x = width / 2.0;
    block(&mut stack, Finish::PlasticGrey, vec3(-x, 0.0, -0.28), vec3(x, height, 0.27));
    let each = height / count as f32;
    for i in 0..count {
        let y = i as f32 * each;
        block(
            &mut stack,
            front,
            vec3(-x + 0.005, y + 0.006, 0.271),
            vec3(x - 0.005, y + each - 0.006, 0.288),
        );
        let (y, z) = (y + each * 0.7, 0.289);
        let handle = [vec3(-0.06, y, z), vec3(-0.06, y, z + 0.03), vec3(0.06, y, z + 0.03), vec3(0.06, y, z)];
        stack.tube(Finish::Steel.surface(), &rounded_line(&handle, 0.015, 1), 0.005, 5);
    }
    stack
}

/// A book that stands on y = 0 with its spine towards +z: covers, rounded spine, and pages between.
#[must_use]
pub fn book(size: Vec3, cover: Finish) -> Mesh {
    /// How far the pages stand back from the covers' edges.
    const BACK: f32 = 0.004;
    let mut book = empty();
    let (x, z) = (size.x / 2.0, size.z / 2.0);
    let (cloth, paper) = (cover.surface(), Finish::Paper.surface());
    let (across, up, deep) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    book.quad(cloth, vec3(-x, 0.0, -z), deep, up, WHOLE);
    book.quad(cloth, vec3(x, 0.0, z), -deep, up, WHOLE);
    book.patch(cloth, [3, 1], |u, v| {
        let turn = (u - 0.5) * TAU / 2.0;
        let position = vec3(libm::sinf(turn) * x, v * size.y, z + libm::cosf(turn) * x * 0.4);
        Vertex { position, along: vec2(u * size.x, v * size.y) }
    });
    book.quad(paper, vec3(x, BACK, BACK - z), -across, up - 2.0 * BACK * Vec3::Y, WHOLE);
    book.quad(paper, vec3(-x, size.y - BACK, z), across, BACK * Vec3::Z - deep, WHOLE);
    book.quad(paper, vec3(-x, BACK, BACK - z), across, deep - BACK * Vec3::Z, WHOLE);
    book
}

/// A bookcase of `shelves` boards and, on each, books, a few leaning or lying, with gaps.
#[must_use]
pub fn bookcase(width: f32, shelves: u32, random: &mut Random) -> Mesh {
    const DEPTH: f32 = 0.30;
    const STEP: f32 = 0.36;
    let mut case = empty();
    let height = 0.08 + shelves as f32 * STEP;
    let x = width / 2.0;
    for side in [-1.0, 1.0] {
        let (a, b) = (side * x, side * (x - 0.02));
        block(&mut case, Finish::Wood, vec3(a.min(b), 0.0, 0.0), vec3(a.max(b), height + 0.02, DEPTH));
    }
    let inner = x - 0.0205;
    block(&mut case, Finish::Wood, vec3(-inner, 0.0, 0.002), vec3(inner, height + 0.018, 0.01));
    for shelf in 0..=shelves {
        let y = 0.06 + shelf as f32 * STEP;
        block(&mut case, Finish::Wood, vec3(-inner, y, 0.011), vec3(inner, y + 0.02, DEPTH - 0.002));
        if shelf < shelves {
            shelf_of_books(&mut case, y + 0.0205, [-inner + 0.005, inner - 0.005], random);
        }
    }
    case
}

/// Fills a shelf from left to right.
fn shelf_of_books(case: &mut Mesh, y: f32, [left, right]: [f32; 2], random: &mut Random) {
    let mut x = left;
    loop {
        let size = vec3(random.between(0.015, 0.055), random.between(0.19, 0.31), random.between(0.15, 0.21));
        let cover = Finish::BOOKS[random.range(0, Finish::BOOKS.len() as u32) as usize];
        let lean = if random.range(0, 9) == 0 { random.between(0.02, 0.035) } else { 0.0 };
        // What a leaning book takes: its thickness, and the way that its top has moved.
        let width = size.x + size.y * libm::sinf(lean * TAU) + 0.001;
        if x + width > right {
            return;
        }
        let stand = vec3(x + width - size.x / 2.0 - 0.0005, y, 0.02 + size.z / 2.0 + 0.04);
        let mut upright = empty();
        upright.append(&book(size, cover), Affine3A::from_translation(vec3(-size.x / 2.0, 0.0, 0.0)));
        let lean = Affine3A::from_rotation_z(lean * TAU);
        case.append(&upright, placed(stand + Vec3::X * size.x / 2.0, 0.0) * lean);
        x += width;
        if random.range(0, 14) == 0 {
            x += random.between(0.05, 0.25);
        }
    }
}

/// A lectern.
#[must_use]
pub fn lectern() -> Mesh {
    let mut lectern = empty();
    block(&mut lectern, Finish::DarkWood, vec3(-0.30, 0.0, -0.25), vec3(0.30, 0.06, 0.25));
    block(&mut lectern, Finish::Wood, vec3(-0.26, 0.061, -0.20), vec3(0.26, 1.02, 0.20));
    let mut top = empty();
    top.rounded_cuboid(
        Finish::DarkWood.surface(),
        [vec3(-0.32, 0.0, -0.27), vec3(0.32, 0.04, 0.27)],
        0.012,
        3,
        [2, 1, 2],
    );
    block(&mut top, Finish::DarkWood, vec3(-0.28, 0.041, -0.25), vec3(0.28, 0.06, -0.235));
    lectern.append(&top, Affine3A::from_translation(vec3(0.0, 1.08, 0.0)) * Affine3A::from_rotation_x(-0.2));
    let neck: Vec<Vec3> =
        rounded_line(&[vec3(0.2, 1.13, 0.1), vec3(0.2, 1.36, 0.1), vec3(0.2, 1.42, -0.12)], 0.15, 8);
    lectern.tube(Finish::PlasticBlack.surface(), &neck, 0.006, 8);
    let mut head = empty();
    head.sphere(Finish::PlasticBlack.surface(), Vec3::ZERO, 0.018, 14, 10);
    lectern.append(&head, Affine3A::from_translation(vec3(0.2, 1.42, -0.13)));
    lectern
}

/// A whiteboard for a wall at z = 0, centred on x, from y = 0.9: frame, tray, pens and an eraser.
#[must_use]
pub fn whiteboard(width: f32, height: f32) -> Mesh {
    let mut board = empty();
    let (x, low, high) = (width / 2.0, 0.9, 0.9 + height);
    block(&mut board, Finish::Whiteboard, vec3(-x, low, 0.004), vec3(x, high, 0.014));
    for (min, max) in [
        (vec3(-x - 0.03, low - 0.03, 0.002), vec3(x + 0.03, low - 0.001, 0.022)),
        (vec3(-x - 0.03, high + 0.001, 0.002), vec3(x + 0.03, high + 0.03, 0.022)),
        (vec3(-x - 0.03, low, 0.002), vec3(-x - 0.001, high, 0.022)),
        (vec3(x + 0.001, low, 0.002), vec3(x + 0.03, high, 0.022)),
        (vec3(-x * 0.8, low - 0.05, 0.003), vec3(x * 0.8, low - 0.04, 0.085)),
        (vec3(-x * 0.8, low - 0.039, 0.078), vec3(x * 0.8, low - 0.03, 0.085)),
    ] {
        block(&mut board, Finish::Steel, min, max);
    }
    let colours = [Finish::SignalRed, Finish::BookBlue, Finish::BookGreen, Finish::PlasticBlack];
    for (i, colour) in colours.into_iter().enumerate() {
        let start = vec3(-0.4 + 0.18 * i as f32, low - 0.030, 0.045 + 0.004 * i as f32);
        let at = |along: f32, radius: f32| (start + Vec3::X * along, radius);
        board.closed_cylinder(Finish::Porcelain.surface(), [at(0.0, 0.009), at(0.085, 0.009)], 8, 1);
        board.closed_cylinder(colour.surface(), [at(0.0855, 0.0095), at(0.125, 0.008)], 8, 1);
    }
    let eraser = [vec3(0.35, low - 0.039, 0.025), vec3(0.48, low - 0.005, 0.07)];
    board.rounded_cuboid(Finish::FabricGrey.surface(), eraser, 0.008, 1, [1, 1, 1]);
    board
}
