//! Small things: what lies on desks, stands in corners and hangs on walls. Each is a mesh that
//! stands on y = 0 around the origin and faces along +z (or hangs on a wall at z = 0), in metres.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use super::finish::Finish;
use super::furniture::{WHOLE, block, empty, placed};
use super::mesh::{Mesh, Vertex, circle, rounded_line};
use saarcor_random::Random;

/// A mug with a handle, of `sides` sides.
#[must_use]
pub fn mug(finish: Finish, sides: u32) -> Mesh {
    let mut mug = empty();
    let profile = [
        vec2(0.0, 0.001),
        vec2(0.032, 0.0),
        vec2(0.037, 0.004),
        vec2(0.040, 0.05),
        vec2(0.041, 0.095),
        vec2(0.039, 0.097),
        vec2(0.037, 0.094),
        vec2(0.036, 0.05),
        vec2(0.033, 0.008),
        vec2(0.0, 0.006),
    ];
    mug.lathe(finish.surface(), &profile, sides);
    let handle =
        [vec3(0.039, 0.075, 0.0), vec3(0.072, 0.08, 0.0), vec3(0.068, 0.025, 0.0), vec3(0.038, 0.02, 0.0)];
    mug.tube(finish.surface(), &rounded_line(&handle, 0.03, 4), 0.005, sides / 3);
    mug
}

/// A cup of paper.
#[must_use]
pub fn paper_cup() -> Mesh {
    let mut cup = empty();
    let profile = [
        vec2(0.0, 0.0),
        vec2(0.028, 0.0),
        vec2(0.030, 0.003),
        vec2(0.036, 0.118),
        vec2(0.035, 0.120),
        vec2(0.034, 0.118),
        vec2(0.0285, 0.014),
        vec2(0.0, 0.011),
    ];
    cup.lathe(Finish::Paper.surface(), &profile, 28);
    cup
}

/// A steel jug with a handle, on a tray.
#[must_use]
pub fn jug() -> Mesh {
    let mut jug = empty();
    let profile = [
        (0.0, 0.008),
        (0.055, 0.008),
        (0.065, 0.020),
        (0.072, 0.08),
        (0.062, 0.15),
        (0.048, 0.20),
        (0.052, 0.235),
        (0.050, 0.236),
        (0.045, 0.20),
        (0.059, 0.15),
        (0.069, 0.08),
        (0.060, 0.022),
        (0.0, 0.018),
    ]
    .map(Vec2::from);
    jug.lathe(Finish::Steel.surface(), &profile, 40);
    let handle =
        [vec3(0.050, 0.215, 0.0), vec3(0.115, 0.21, 0.0), vec3(0.11, 0.09, 0.0), vec3(0.071, 0.08, 0.0)];
    jug.tube(Finish::Steel.surface(), &rounded_line(&handle, 0.05, 8), 0.007, 12);
    let tray = [(0.0, 0.001), (0.15, 0.001), (0.165, 0.012), (0.163, 0.013), (0.149, 0.004), (0.0, 0.004)];
    jug.lathe(Finish::Steel.surface(), &tray.map(Vec2::from), 48);
    jug
}

/// A ball pen that lies along x.
#[must_use]
pub fn pen(finish: Finish) -> Mesh {
    let mut pen = empty();
    let at = |x: f32, radius: f32| (vec3(x, 0.0055, 0.0), radius);
    pen.closed_cylinder(finish.surface(), [at(-0.065, 0.0045), at(0.05, 0.0045)], 10, 1);
    pen.cylinder(Finish::Steel.surface(), [at(0.05, 0.0045), at(0.068, 0.001)], 10, 1);
    pen.closed_cylinder(Finish::Steel.surface(), [at(-0.074, 0.002), at(-0.0655, 0.002)], 8, 1);
    block(&mut pen, Finish::Steel, vec3(-0.06, 0.0102, -0.001), vec3(-0.02, 0.011, 0.001));
    pen
}

/// A pad with a spiral of wire along its far edge.
#[must_use]
pub fn spiral_pad(turns: u32) -> Mesh {
    let mut pad = empty();
    block(&mut pad, Finish::BookOchre, vec3(-0.105, 0.001, -0.145), vec3(0.105, 0.003, 0.148));
    block(&mut pad, Finish::Paper, vec3(-0.105, 0.0035, -0.145), vec3(0.105, 0.012, 0.148));
    let wire: Vec<Vec3> = (0..=turns * 6)
        .map(|i| {
            let turn = circle(i as f32 / 6.0) * 0.009;
            let x = -0.095 + 0.19 * i as f32 / (turns * 6) as f32;
            vec3(x, 0.0105 + turn.x, -0.147 + turn.y)
        })
        .collect();
    pad.tube(Finish::Steel.surface(), &wire, 0.0008, 4);
    pad
}

/// A sheet of paper, one corner of it curled up.
#[must_use]
pub fn sheet(curl: f32) -> Mesh {
    let mut sheet = empty();
    sheet.patch(Finish::Paper.surface(), [4, 4], |u, v| {
        let lift = (u + v - 1.2).max(0.0);
        let position = vec3((u - 0.5) * 0.21, 0.0015 + curl * lift * lift, (0.5 - v) * 0.297);
        Vertex { position, along: vec2(u, v) }
    });
    sheet
}

/// A book that lies flat.
#[must_use]
pub fn lying(book: &Mesh, thickness: f32) -> Mesh {
    let mut flat = empty();
    flat.append(
        book,
        Affine3A::from_translation(vec3(0.0, thickness / 2.0 + 0.001, 0.0))
            * Affine3A::from_rotation_z(TAU / 4.0),
    );
    flat
}

/// Rows of keys on y = 0, `pitch` apart, centred: each a small box that narrows upwards.
fn keys(mesh: &mut Mesh, finish: Finish, columns: u32, rows: u32, pitch: f32, at: Vec3) {
    let key = [(Vec3::ZERO, pitch * 0.62), (Vec3::Y * pitch * 0.28, pitch * 0.5)];
    let mut cap = empty();
    cap.cylinder(finish.surface(), key, 4, 1);
    let top = key[1];
    cap.quad(
        finish.surface(),
        top.0 + Vec3::Z * top.1,
        vec3(top.1, 0.0, -top.1),
        vec3(-top.1, 0.0, -top.1),
        WHOLE,
    );
    for row in 0..rows {
        for column in 0..columns {
            // The prism of four sides has its corners on the axes.
            let x = (column as f32 - (columns - 1) as f32 / 2.0) * pitch;
            let z = (row as f32 - (rows - 1) as f32 / 2.0) * pitch;
            mesh.append(&cap, placed(at + vec3(x, 0.0, z), 0.125));
        }
    }
}

/// A laptop, open.
#[must_use]
pub fn laptop() -> Mesh {
    let mut laptop = empty();
    let shell = Finish::PlasticGrey.surface();
    laptop.rounded_cuboid(shell, [vec3(-0.17, 0.001, -0.12), vec3(0.17, 0.022, 0.12)], 0.008, 3, [1, 1, 1]);
    keys(&mut laptop, Finish::PlasticBlack, 15, 5, 0.019, vec3(0.0, 0.0222, -0.03));
    block(&mut laptop, Finish::PlasticBlack, vec3(-0.04, 0.0221, 0.05), vec3(0.04, 0.0228, 0.10));
    let mut lid = empty();
    lid.rounded_cuboid(shell, [vec3(-0.17, 0.0, -0.005), vec3(0.17, 0.235, 0.005)], 0.004, 3, [1, 1, 1]);
    block(&mut lid, Finish::Screen, vec3(-0.155, 0.02, 0.0052), vec3(0.155, 0.22, 0.006));
    laptop
        .append(&lid, Affine3A::from_translation(vec3(0.0, 0.022, -0.125)) * Affine3A::from_rotation_x(-0.3));
    laptop
}

/// A computer of the time: tube monitor, keyboard, mouse with its cable, and a tower beside.
#[must_use]
pub fn computer(tower: bool) -> Mesh {
    let mut set = empty();
    let shell = Finish::PlasticBeige.surface();
    set.lathe(shell, &[(0.13, 0.0), (0.12, 0.02), (0.05, 0.03), (0.05, 0.06)].map(Vec2::from), 12);
    let mut tube = empty();
    tube.rounded_cuboid(shell, [vec3(-0.20, 0.06, -0.20), vec3(0.20, 0.41, 0.18)], 0.02, 1, [1, 1, 3]);
    // Narrower towards the back.
    let tube = tube.bent(|p| {
        let narrow = 1.0 - 0.45 * ((0.05 - p.z) / 0.25).clamp(0.0, 1.0);
        vec3(p.x * narrow, 0.235 + (p.y - 0.235) * narrow, p.z)
    });
    set.append(&tube, Affine3A::IDENTITY);
    set.patch(Finish::Screen.surface(), [4, 4], |u, v| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let bulge = 0.181 + 0.012 * (1.0 - x * x) * (1.0 - y * y);
        Vertex { position: vec3(0.165 * x, 0.245 + 0.13 * y, bulge), along: vec2(x, y) }
    });
    let board = [vec3(-0.22, 0.002, 0.26), vec3(0.22, 0.022, 0.41)];
    set.rounded_cuboid(shell, board, 0.006, 1, [1, 1, 1]);
    keys(&mut set, Finish::Porcelain, 10, 3, 0.042, vec3(0.0, 0.0222, 0.335));
    let mouse = [vec3(0.28, 0.002, 0.29), vec3(0.34, 0.035, 0.39)];
    set.rounded_cuboid(shell, mouse, 0.015, 1, [1, 1, 1]);
    let cable = [
        vec3(0.31, 0.015, 0.292),
        vec3(0.31, 0.006, 0.22),
        vec3(0.34, 0.005, 0.08),
        vec3(0.25, 0.005, -0.1),
        vec3(0.30, 0.005, -0.26),
    ];
    set.tube(Finish::PlasticGrey.surface(), &rounded_line(&cable, 0.09, 3), 0.003, 4);
    if tower {
        set.append(&tower_case(), placed(vec3(-0.42, 0.0, 0.0), 0.0));
    }
    set
}

/// The case of a computer: drives, buttons and slots for air.
fn tower_case() -> Mesh {
    let mut case = empty();
    let shell = [vec3(-0.09, 0.002, -0.22), vec3(0.09, 0.42, 0.20)];
    case.rounded_cuboid(Finish::PlasticBeige.surface(), shell, 0.008, 1, [1, 1, 1]);
    for (y, height, finish) in [
        (0.34, 0.04, Finish::PlasticGrey),
        (0.29, 0.04, Finish::PlasticBeige),
        (0.25, 0.02, Finish::PlasticBlack),
    ] {
        block(&mut case, finish, vec3(-0.075, y, 0.2005), vec3(0.075, y + height, 0.206));
    }
    let button = |y: f32, z: f32| (vec3(0.05, y, z), 0.01);
    case.closed_cylinder(Finish::SignalRed.surface(), [button(0.2, 0.2005), button(0.2, 0.208)], 10, 1);
    for slot in 0..8 {
        let y = 0.03 + 0.012 * slot as f32;
        block(&mut case, Finish::PlasticBlack, vec3(-0.06, y, 0.2005), vec3(0.06, y + 0.005, 0.203));
    }
    case
}

/// A telephone with a handset and its curly cord.
#[must_use]
pub fn telephone() -> Mesh {
    let mut phone = empty();
    let plastic = Finish::PlasticBlack.surface();
    let mut body = empty();
    body.rounded_cuboid(plastic, [vec3(-0.09, 0.0, -0.10), vec3(0.09, 0.04, 0.10)], 0.012, 1, [1, 1, 1]);
    // Higher at the back.
    let slope = |p: Vec3| if p.y > 0.02 { p + Vec3::Y * (0.1 - p.z) * 0.15 } else { p };
    phone.append(&body.bent(slope), Affine3A::from_translation(Vec3::Y * 0.001));
    keys(&mut phone, Finish::PlasticGrey, 3, 4, 0.022, vec3(0.035, 0.058, 0.02));
    let handset = [vec3(-0.08, 0.075, -0.09), vec3(-0.03, 0.10, 0.11)];
    phone.rounded_cuboid(plastic, handset, 0.011, 1, [1, 1, 3]);
    for z in [-0.07, 0.09] {
        let cup = [(vec3(-0.055, 0.055, z), 0.026), (vec3(-0.055, 0.08, z), 0.022)];
        phone.closed_cylinder(plastic, cup, 10, 1);
    }
    let cord: Vec<Vec3> = (0..=48)
        .map(|i| {
            let s = i as f32 / 48.0;
            let turn = circle(s * 12.0) * 0.007;
            vec3(-0.10 - 0.05 * libm::sinf(s * TAU / 2.0) + turn.x * 0.5, 0.009 + turn.y, 0.1 - 0.16 * s)
        })
        .collect();
    phone.tube(plastic, &cord, 0.0015, 3);
    phone
}

/// A desk lamp on a jointed arm.
#[must_use]
pub fn desk_lamp() -> Mesh {
    let mut lamp = empty();
    let black = Finish::PlasticBlack.surface();
    lamp.lathe(black, &[(0.09, 0.001), (0.09, 0.012), (0.02, 0.025), (0.0, 0.026)].map(Vec2::from), 16);
    let arm = [vec3(0.0, 0.02, 0.0), vec3(0.0, 0.36, -0.14), vec3(0.0, 0.50, 0.14)];
    for x in [-0.01, 0.01] {
        let rod: Vec<Vec3> = arm.iter().map(|p| *p + Vec3::X * x).collect();
        lamp.tube(Finish::Steel.surface(), &rounded_line(&rod, 0.01, 2), 0.004, 6);
    }
    let joint = |x: f32| (vec3(x, 0.36, -0.14), 0.015);
    lamp.closed_cylinder(black, [joint(-0.018), joint(0.018)], 12, 1);
    let mut shade = empty();
    let bell = [(0.075, 0.0), (0.07, 0.03), (0.04, 0.075), (0.025, 0.10), (0.0, 0.105)].map(Vec2::from);
    shade.lathe(black, &bell, 16);
    shade.sphere(Finish::Lamp.surface(), Vec3::Y * 0.035, 0.028, 8, 6);
    lamp.append(&shade, Affine3A::from_translation(vec3(0.0, 0.43, 0.18)) * Affine3A::from_rotation_x(-0.5));
    lamp
}

/// A waste-paper bin with crumpled paper in it.
#[must_use]
pub fn bin(random: &mut Random) -> Mesh {
    let mut bin = empty();
    let wall = [(0.0, 0.002), (0.11, 0.002), (0.14, 0.30), (0.145, 0.302), (0.136, 0.30), (0.107, 0.008)];
    bin.lathe(Finish::PlasticGrey.surface(), &wall.map(Vec2::from), 14);
    for _ in 0..2 {
        let mut ball = empty();
        let at = circle(random.unit()) * random.between(0.0, 0.06);
        let radius = random.between(0.03, 0.045);
        ball.sphere(Finish::Paper.surface(), Vec3::ZERO, radius, 8, 6);
        let crumple = [random.between(0.2, 0.3), random.between(60.0, 90.0)];
        let ball = ball
            .bent(|p| p * (1.0 + crumple[0] * libm::sinf((p.x - p.z) * crumple[1]) * libm::cosf(p.y * 80.0)));
        bin.append(&ball, placed(vec3(at.x, random.between(0.06, 0.2), at.y), random.unit()));
    }
    bin
}

/// A bin woven of wire.
#[must_use]
pub fn wire_bin() -> Mesh {
    const WIRES: u32 = 32;
    let mut bin = empty();
    let steel = Finish::Steel.surface();
    let ring = |radius: f32, y: f32| -> Vec<Vec3> {
        (0..=32).map(|i| circle(i as f32 / 32.0) * radius).map(|p| vec3(p.x, y, p.y)).collect()
    };
    for level in 0..=8 {
        let s = level as f32 / 8.0;
        bin.tube(steel, &ring(0.10 + 0.04 * s, 0.004 + 0.30 * s), 0.0022, 5);
    }
    for i in 0..WIRES {
        let out = circle(i as f32 / WIRES as f32);
        let (foot, rim) = (out * 0.1025, out * 0.1425);
        let wire = [(vec3(foot.x, 0.002, foot.y), 0.0018), (vec3(rim.x, 0.305, rim.y), 0.0018)];
        bin.cylinder(steel, wire, 5, 1);
    }
    bin.disc(steel, Vec3::Y * 0.003, Vec3::Y, 0.10, 32);
    bin
}

/// A plant in a pot, its leaves on bent stalks that reach out by 0.3 and a fifth of the height.
#[must_use]
pub fn plant(height: f32, leaves: u32, random: &mut Random) -> Mesh {
    let mut plant = empty();
    let pot =
        [(0.0, 0.0), (0.11, 0.0), (0.15, 0.22), (0.165, 0.22), (0.165, 0.26), (0.145, 0.26), (0.14, 0.22)];
    plant.lathe(Finish::Terracotta.surface(), &pot.map(Vec2::from), 24);
    plant.disc(Finish::Soil.surface(), Vec3::Y * 0.222, Vec3::Y, 0.139, 24);
    for i in 0..leaves {
        let rise = random.between(0.35, 1.0) * (height - 0.3);
        let reach = random.between(0.06, 0.2) * height;
        let mut stalk = empty();
        let bow = |s: f32| vec3(0.0, 0.22 + rise * (1.0 - (1.0 - s) * (1.0 - s)), reach * s * s);
        let points: Vec<Vec3> = (0..=5).map(|k| bow(k as f32 / 5.0)).collect();
        stalk.tube(Finish::Leaf.surface(), &points, 0.004, 4);
        let (length, width) = (random.between(0.16, 0.25), random.between(0.03, 0.05));
        let droop = random.between(0.2, 0.9);
        stalk.patch(Finish::Leaf.surface(), [2, 7], |u, v| {
            let half = width * libm::sinf(v * TAU / 2.0) * (1.0 - 0.3 * v);
            let side = 2.0 * u - 1.0;
            let fold = 0.3 * half * side.abs();
            let position = bow(1.0) + vec3(side * half, fold - droop * length * v * v, length * v);
            Vertex { position, along: vec2(side * half, length * v) }
        });
        let turns = i as f32 * 0.381_966 + random.between(-0.05, 0.05);
        let from = circle(random.unit()) * 0.05;
        plant.append(&stalk, placed(vec3(from.x, 0.0, from.y), turns));
    }
    plant
}

/// A clock for a wall.
#[must_use]
pub fn clock() -> Mesh {
    let mut clock = empty();
    let rim = [(0.155, 0.0), (0.16, 0.01), (0.16, 0.03), (0.152, 0.036), (0.145, 0.03), (0.145, 0.012)];
    clock.lathe(Finish::PlasticBlack.surface(), &rim.map(Vec2::from), 60);
    clock.disc(Finish::Porcelain.surface(), Vec3::Y * 0.012, Vec3::Y, 0.144, 60);
    for minute in 0..60 {
        let (length, width) = if minute % 5 == 0 { (0.02, 0.003) } else { (0.008, 0.001) };
        let mut tick = empty();
        block(
            &mut tick,
            Finish::PlasticBlack,
            vec3(-width, 0.013, 0.138 - length),
            vec3(width, 0.0135, 0.138),
        );
        clock.append(&tick, placed(Vec3::ZERO, minute as f32 / 60.0));
    }
    for (turns, length, width, y) in
        [(0.18, 0.08, 0.005, 0.015), (0.63, 0.12, 0.003, 0.018), (0.4, 0.13, 0.001, 0.021)]
    {
        let mut hand = empty();
        let finish = if width > 0.002 { Finish::PlasticBlack } else { Finish::SignalRed };
        block(&mut hand, finish, vec3(-width, y, -0.02), vec3(width, y + 0.001, length));
        clock.append(&hand, placed(Vec3::ZERO, turns));
    }
    let mut upright = empty();
    upright.append(&clock, Affine3A::from_rotation_x(TAU / 4.0));
    upright
}

/// A fire extinguisher on a wall at z = 0.
#[must_use]
pub fn extinguisher() -> Mesh {
    let mut bottle = empty();
    let red = Finish::SignalRed.surface();
    let body =
        [(0.0, 0.0), (0.07, 0.0), (0.075, 0.01), (0.075, 0.42), (0.06, 0.47), (0.025, 0.50), (0.025, 0.52)];
    bottle.lathe(red, &body.map(Vec2::from), 16);
    bottle.closed_cylinder(Finish::Brass.surface(), [(Vec3::Y * 0.52, 0.02), (Vec3::Y * 0.56, 0.018)], 14, 1);
    for (y, lift) in [(0.565, 0.0), (0.585, 0.02)] {
        block(&mut bottle, Finish::Steel, vec3(-0.012, y, -0.02), vec3(0.012, y + 0.005, 0.10 + lift));
    }
    let hose =
        [vec3(0.02, 0.54, 0.0), vec3(0.09, 0.53, 0.02), vec3(0.10, 0.35, 0.03), vec3(0.095, 0.12, 0.03)];
    bottle.tube(Finish::PlasticBlack.surface(), &rounded_line(&hose, 0.08, 5), 0.009, 6);
    let mut hung = empty();
    hung.append(&bottle, placed(vec3(0.0, 0.25, 0.09), 0.0));
    block(&mut hung, Finish::Steel, vec3(-0.04, 0.40, 0.001), vec3(0.04, 0.60, 0.012));
    hung
}

/// A framed picture for a wall at z = 0, centred at the origin.
#[must_use]
pub fn picture(size: Vec2, finish: Finish) -> Mesh {
    const FRAME: f32 = 0.03;
    let mut picture = empty();
    let (x, y) = (size.x / 2.0, size.y / 2.0);
    block(&mut picture, Finish::Paper, vec3(-x, -y, 0.002), vec3(x, y, 0.008));
    block(&mut picture, finish, vec3(-x * 0.75, -y * 0.75, 0.0085), vec3(x * 0.75, y * 0.75, 0.010));
    // Four mitred mouldings, each a wedge profile carried along its side.
    let profile = [(0.0, 0.002), (0.0, 0.012), (0.4, 0.022), (0.8, 0.024), (1.0, 0.016), (1.0, 0.002)];
    let corners = [vec2(-x, -y), vec2(x, -y), vec2(x, y), vec2(-x, y)];
    for i in 0..4 {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        picture.patch(Finish::DarkWood.surface(), [1, 5], |u, v| {
            let (out, z) = profile[5 - (v * 5.0).round() as usize];
            let spread = |c: Vec2| c + c.signum() * out * FRAME;
            let p = spread(from).lerp(spread(to), u);
            Vertex { position: p.extend(z), along: vec2(u, v) }
        });
    }
    picture
}

/// A notice board for a wall at z = 0, centred at the origin, with pinned sheets.
#[must_use]
pub fn notice_board(size: Vec2, sheets: u32, random: &mut Random) -> Mesh {
    let mut board = picture(size, Finish::BookOchre);
    for i in 0..sheets {
        let column = (i as f32 + 0.5) / sheets as f32 - 0.5;
        let centre = vec3(column * (size.x - 0.25), random.between(-0.12, 0.12) * size.y, 0.012);
        let mut note = empty();
        let (x, y) = (random.between(0.07, 0.105), random.between(0.10, 0.148));
        note.patch(Finish::Paper.surface(), [2, 4], |u, v| {
            let curl = 0.03 * (1.0 - v).powi(3);
            let position = vec3((2.0 * u - 1.0) * x, (2.0 * v - 1.0) * y, curl);
            Vertex { position, along: vec2(u, v) }
        });
        let pin = vec3(0.0, y * 0.9, 0.001);
        note.closed_cylinder(
            Finish::SignalRed.surface(),
            [(pin, 0.003), (pin + Vec3::Z * 0.008, 0.005)],
            8,
            1,
        );
        let layer = Vec3::Z * 0.0004 * i as f32;
        let tilt = Affine3A::from_rotation_z(random.between(-0.08, 0.08));
        board.append(&note, Affine3A::from_translation(centre + layer) * tilt);
    }
    board
}

/// A copier with paper trays and a panel.
#[must_use]
pub fn copier() -> Mesh {
    let mut copier = empty();
    let shell = Finish::PlasticBeige.surface();
    copier.rounded_cuboid(shell, [vec3(-0.45, 0.03, -0.32), vec3(0.45, 0.85, 0.32)], 0.02, 1, [1, 1, 1]);
    copier.rounded_cuboid(shell, [vec3(-0.44, 0.87, -0.31), vec3(0.44, 0.97, 0.28)], 0.02, 1, [1, 1, 1]);
    for tray in 0..3 {
        let y = 0.12 + 0.18 * tray as f32;
        block(&mut copier, Finish::PlasticGrey, vec3(-0.35, y, 0.321), vec3(0.35, y + 0.15, 0.335));
        block(&mut copier, Finish::PlasticBlack, vec3(-0.1, y + 0.1, 0.336), vec3(0.1, y + 0.12, 0.345));
    }
    keys(&mut copier, Finish::PlasticGrey, 5, 4, 0.025, vec3(0.3, 0.852, 0.30));
    copier.quad(
        Finish::PlasticGrey.surface(),
        vec3(0.46, 0.60, 0.25),
        Vec3::NEG_Z * 0.5,
        vec3(0.25, 0.12, 0.0),
        WHOLE,
    );
    copier
}
