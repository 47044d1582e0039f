//! What a building is made of: walls with openings, doors, windows, blinds, lamps, ceilings, stairs
//! and railings. Metres, y up; each part says where it stands.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec2, vec3};

use super::finish::Finish;
use super::furniture::{WHOLE, block, empty, placed};
use super::mesh::{Mesh, Vertex, rounded_line};

/// An opening in a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// From where to where along the wall.
    pub along: [f32; 2],
    /// From which height to which, in the space of the wall's own heights.
    pub y: [f32; 2],
}

/// Adds a wall over the line from `from` to `to` (x and z), from height `y[0]` to `y[1]`. Its
/// `openings`, apart from each other, have reveals as deep as the wall is thick. The ends,
/// the top and the foot stay open: other walls, the ceiling and the floor close them.
pub fn wall(
    mesh: &mut Mesh,
    finish: Finish,
    [from, to]: [Vec2; 2],
    y: [f32; 2],
    thickness: f32,
    openings: &[Opening],
) {
    let length = from.distance(to);
    let dir = (to - from) / length;
    let side = vec2(-dir.y, dir.x) * thickness / 2.0;
    let at = |along: f32, y: f32, side: Vec2| {
        let p = from + dir * along + side;
        vec3(p.x, y, p.y)
    };
    let surface = finish.surface();
    let up = Vec3::Y * (y[1] - y[0]);
    for (start, end, side) in [(0.0, length, side), (length, 0.0, -side)] {
        let hole = |o: &Opening| {
            let corner = |i: usize| vec2((o.along[i] - start).abs(), o.y[i] - y[0]);
            (corner(0), corner(1))
        };
        let holes: Vec<_> = openings.iter().map(hole).collect();
        let origin = at(start, y[0], side);
        mesh.pierced_quad(surface, [origin, at(end, y[0], side) - origin, up], &holes, WHOLE);
    }
    for opening in openings {
        let [start, end] = opening.along;
        let [low, high] = opening.y;
        let across = at(0.0, 0.0, -side) - at(0.0, 0.0, side);
        let (up, over) = (Vec3::Y * (high - low), at(end, 0.0, side) - at(start, 0.0, side));
        mesh.quad(surface, at(start, low, side), across, up, WHOLE);
        mesh.quad(surface, at(end, low, -side), -across, up, WHOLE);
        if high < y[1] {
            mesh.quad(surface, at(start, high, -side), over, -across, WHOLE);
        }
        if low > y[0] {
            mesh.quad(surface, at(start, low, side), over, across, WHOLE);
        }
    }
}

/// Adds a floor (front up) or, if `down`, a ceiling over a rectangle of x and z, in cells no longer
/// than `cell`.
pub fn slab(mesh: &mut Mesh, finish: Finish, min: Vec2, max: Vec2, y: f32, down: bool, cell: f32) {
    let (x, z) = (Vec3::X * (max.x - min.x), Vec3::Z * (max.y - min.y));
    let (right, up) = if down { (x, z) } else { (x, -z) };
    let origin = vec3(min.x, y, min.y) + if down { Vec3::ZERO } else { z };
    mesh.quad(finish.surface(), origin, right, up, cell);
}

/// A door leaf with panels, hinges and lever handles: its hinges at the origin, from there along +x.
#[must_use]
pub fn door_leaf(width: f32, height: f32, finish: Finish) -> Mesh {
    const HALF: f32 = 0.02;
    let mut door = empty();
    block(&mut door, finish, vec3(0.003, 0.008, -HALF), vec3(width - 0.003, height - 0.003, HALF));
    for side in [-1.0, 1.0] {
        let face = |depth: f32| side * (HALF + depth);
        // Two raised panels.
        for (low, high) in [(0.18, 0.85), (1.15, height - 0.15)] {
            let z = [face(0.0), face(0.012)];
            let (min, max) = (vec3(0.14, low, z[0].min(z[1])), vec3(width - 0.14, high, z[0].max(z[1])));
            block(&mut door, finish, min, max);
        }
        let x = width - 0.07;
        let rose = [(vec3(x, 1.0, face(0.0005)), 0.026), (vec3(x, 1.0, face(0.008)), 0.024)];
        door.closed_cylinder(Finish::Steel.surface(), rose, 10, 1);
        let lever = [
            vec3(x, 1.0, face(0.008)),
            vec3(x, 1.0, face(0.055)),
            vec3(x - 0.12, 1.0, face(0.055)),
            vec3(x - 0.13, 1.0, face(0.04)),
        ];
        door.tube(Finish::Steel.surface(), &rounded_line(&lever, 0.02, 2), 0.008, 5);
    }
    for y in [0.2, height / 2.0, height - 0.25] {
        let knuckle = [(vec3(0.0, y, HALF), 0.008), (vec3(0.0, y + 0.09, HALF), 0.008)];
        door.closed_cylinder(Finish::Brass.surface(), knuckle, 8, 1);
    }
    door
}

/// The architraves of a door: around an opening from the origin along +x, on both faces of a wall
/// around z = 0.
#[must_use]
pub fn door_frame(width: f32, height: f32, wall: f32) -> Mesh {
    const WIDE: f32 = 0.07;
    let mut frame = empty();
    for side in [-1.0, 1.0] {
        let z = [side * wall / 2.0, side * (wall / 2.0 + 0.015)];
        let (near, far) = (z[0].min(z[1]), z[0].max(z[1]));
        for (min, max) in [
            (vec2(-WIDE, 0.0), vec2(0.0, height)),
            (vec2(width, 0.0), vec2(width + WIDE, height)),
            (vec2(-WIDE, height), vec2(width + WIDE, height + WIDE)),
        ] {
            block(&mut frame, Finish::DarkWood, min.extend(near), max.extend(far));
        }
    }
    frame
}

/// A window's frame and glazing bars, and panes if `glazed`, around z = 0, from the origin along +x
/// and +y, in `panes` columns.
#[must_use]
pub fn window(size: Vec2, columns: u32, glazed: bool) -> Mesh {
    const BAR: f32 = 0.025;
    let mut window = empty();
    let bars = columns + 1;
    let post = |i: u32| BAR + (size.x - 2.0 * BAR) * i as f32 / columns as f32;
    for i in 0..bars {
        let x = post(i);
        block(&mut window, Finish::Steel, vec3(x - BAR, 0.0, -0.03), vec3(x + BAR, size.y, 0.03));
    }
    for i in 0..columns {
        let (left, right) = (post(i) + BAR, post(i + 1) - BAR);
        for y in [0.0, size.y * 0.7, size.y - 2.0 * BAR] {
            block(&mut window, Finish::Steel, vec3(left, y, -0.028), vec3(right, y + 2.0 * BAR, 0.028));
        }
        if glazed {
            for (low, high) in [(2.0 * BAR, size.y * 0.7), (size.y * 0.7 + 2.0 * BAR, size.y - 2.0 * BAR)] {
                block(&mut window, Finish::Pane, vec3(left, low, -0.003), vec3(right, high, 0.003));
            }
        }
    }
    window
}

/// A venetian blind that hangs down from the origin along +x: a head rail, slats of a profile
/// curved in `cells` steps and tilted by `tilt` turns, and their cords.
#[must_use]
pub fn venetian_blind(width: f32, slats: u32, cells: u32, tilt: f32) -> Mesh {
    const PITCH: f32 = 0.025;
    let mut blind = empty();
    block(&mut blind, Finish::Steel, vec3(0.0, -0.035, -0.02), vec3(width, 0.0, 0.02));
    let (sin, cos) = libm::sincosf(tilt * TAU);
    for i in 0..slats {
        let y = -0.05 - PITCH * i as f32;
        blind.patch(Finish::Slat.surface(), [1, cells], |u, v| {
            let (across, bow) = ((v - 0.5) * 0.026, 0.004 * (1.0 - (2.0 * v - 1.0).powi(2)));
            let position =
                vec3(0.005 + u * (width - 0.01), y + bow * cos + across * sin, bow * sin - across * cos);
            Vertex { position, along: vec2(u, v) }
        });
    }
    let foot = -0.05 - PITCH * slats as f32;
    block(&mut blind, Finish::Slat, vec3(0.005, foot - 0.012, -0.012), vec3(width - 0.005, foot, 0.012));
    for along in [0.15, 0.85] {
        for z in [-0.016, 0.016] {
            let cord = [(vec3(width * along, foot, z), 0.0008), (vec3(width * along, -0.036, z), 0.0008)];
            blind.cylinder(Finish::Slat.surface(), cord, 4, 1);
        }
    }
    let wand = [(vec3(0.06, -0.7, 0.03), 0.004), (vec3(0.06, -0.03, 0.025), 0.004)];
    blind.closed_cylinder(Finish::Slat.surface(), wand, 6, 1);
    blind
}

/// A blind of vertical vanes that hang down from the origin along +x, each of a curved profile and
/// tilted by `tilt` turns, with carriers above and bead chains between them below.
#[must_use]
pub fn vertical_blind(width: f32, height: f32, tilt: f32) -> Mesh {
    const PITCH: f32 = 0.085;
    let mut blind = empty();
    block(&mut blind, Finish::Steel, vec3(0.0, -0.04, -0.025), vec3(width, 0.0, 0.025));
    let (sin, cos) = libm::sincosf(tilt * TAU);
    let vanes = (width / PITCH) as u32;
    for i in 0..vanes {
        let x = PITCH * (i as f32 + 0.5);
        let turned = |across: f32, bow: f32| vec2(x + across * cos - bow * sin, across * sin + bow * cos);
        blind.patch(Finish::Slat.surface(), [8, 3], |u, v| {
            let p = turned((u - 0.5) * 0.089, 0.006 * (1.0 - (2.0 * u - 1.0).powi(2)));
            let y = -height + (height - 0.07) * v;
            Vertex { position: vec3(p.x, y, p.y), along: vec2(u, v) }
        });
        let stem = [(vec3(x, -0.072, 0.0), 0.004), (vec3(x, -0.0405, 0.0), 0.006)];
        blind.closed_cylinder(Finish::PlasticGrey.surface(), stem, 6, 1);
        let hem = turned(0.0, 0.007);
        let weight = [vec3(x - 0.03, 0.01 - height, hem.y), vec3(x + 0.03, 0.03 - height, hem.y + 0.002)];
        block(&mut blind, Finish::PlasticGrey, weight[0], weight[1]);
        if i + 1 == vanes {
            break;
        }
        for end in [-0.04, 0.04] {
            let start = turned(end, 0.0);
            let chain: Vec<Vec3> = (0..=7)
                .map(|k| {
                    let s = k as f32 / 7.0;
                    let sag = 0.015 * 4.0 * s * (1.0 - s);
                    vec3(start.x + PITCH * s, 0.015 - height - sag, start.y)
                })
                .collect();
            blind.tube(Finish::Steel.surface(), &chain, 0.0012, 4);
        }
    }
    blind
}

/// A curtain that hangs down from the origin along +x, its folds deeper towards the hem, on rings.
#[must_use]
pub fn curtain(width: f32, height: f32, folds: u32) -> Mesh {
    let mut curtain = empty();
    curtain.patch(Finish::Curtain.surface(), [folds * 10, 5], |u, v| {
        let phase = u * folds as f32 * TAU;
        let deep = 0.025 + 0.035 * (1.0 - v);
        let position = vec3(
            u * width + 0.012 * libm::sinf(2.0 * phase),
            -height * (1.0 - v) - 0.03,
            deep * libm::sinf(phase),
        );
        Vertex { position, along: vec2(u, v) }
    });
    let rod = |x: f32| (vec3(x, 0.0, 0.0), 0.012);
    curtain.closed_cylinder(Finish::Brass.surface(), [rod(-0.1), rod(width + 0.1)], 12, 1);
    for i in 0..folds {
        let x = (i as f32 + 0.5) * width / folds as f32;
        let ring: Vec<Vec3> = (0..=16)
            .map(|k| vec2(0.019, 0.0).rotate(Vec2::from_angle(k as f32 / 16.0 * TAU)))
            .map(|p| vec3(x, p.x, p.y))
            .collect();
        curtain.tube(Finish::Brass.surface(), &ring, 0.0025, 6);
    }
    curtain
}

/// A lamp of two tubes behind a louvre, 1.2 by 0.3 and 0.08 deep, its lower edge at y = 0.
#[must_use]
pub fn louvre_lamp(blades: u32) -> Mesh {
    let mut lamp = empty();
    let (x, z) = (0.6, 0.15);
    let steel = Finish::Steel.surface();
    for (origin, right) in [
        (vec3(-x, 0.0, z), Vec3::X * 2.0 * x),
        (vec3(x, 0.0, z), Vec3::NEG_Z * 2.0 * z),
        (vec3(x, 0.0, -z), Vec3::NEG_X * 2.0 * x),
        (vec3(-x, 0.0, -z), Vec3::Z * 2.0 * z),
    ] {
        lamp.quad(steel, origin, right, Vec3::Y * 0.08, WHOLE);
    }
    slab(&mut lamp, Finish::Lamp, vec2(-x, -z), vec2(x, z), 0.08, true, WHOLE);
    for side in [-0.07, 0.07] {
        let tube = [(vec3(-x + 0.02, 0.05, side), 0.013), (vec3(x - 0.02, 0.05, side), 0.013)];
        lamp.cylinder(Finish::Lamp.surface(), tube, 10, 1);
    }
    for i in 0..blades {
        let at = -x + 2.0 * x * (i as f32 + 0.5) / blades as f32;
        for side in [-1.0, 1.0] {
            lamp.patch(steel, [1, 2], |u, v| {
                let thick = 0.002 + 0.006 * v * v;
                let position =
                    vec3(at + side * thick, 0.001 + 0.034 * v, -side * (2.0 * u - 1.0) * (z - 0.001));
                Vertex { position, along: vec2(u, v) }
            });
        }
    }
    lamp
}

/// A radiator of `columns` columns, 0.6 high, against a wall at z = 0, centred on x.
#[must_use]
pub fn radiator(columns: u32) -> Mesh {
    const PITCH: f32 = 0.05;
    let mut radiator = empty();
    let width = PITCH * columns as f32;
    for i in 0..columns {
        let x = (i as f32 + 0.5) * PITCH - width / 2.0;
        let column = [(vec3(x, 0.12, 0.09), 0.021), (vec3(x, 0.70, 0.09), 0.021)];
        radiator.closed_cylinder(Finish::Porcelain.surface(), column, 8, 1);
    }
    for y in [0.17, 0.65] {
        let pipe = [(vec3(-width / 2.0 - 0.05, y, 0.09), 0.014), (vec3(width / 2.0 + 0.05, y, 0.09), 0.014)];
        radiator.closed_cylinder(Finish::Porcelain.surface(), pipe, 10, 1);
    }
    radiator
}

/// A railing from the origin along +x: posts, a round handrail at 1.05, and thin bars between.
#[must_use]
pub fn railing(length: f32) -> Mesh {
    let mut railing = empty();
    let steel = Finish::Steel.surface();
    let rail = |y: f32, radius: f32| [(vec3(0.0, y, 0.0), radius), (vec3(length, y, 0.0), radius)];
    railing.cylinder(Finish::Wood.surface(), rail(1.05, 0.028), 12, 1);
    railing.cylinder(steel, rail(0.12, 0.012), 8, 1);
    railing.cylinder(steel, rail(0.96, 0.012), 8, 1);
    let bars = (length / 0.16) as u32;
    for i in 0..=bars {
        let x = length * i as f32 / bars as f32;
        let (foot, radius, sides) = if i % 10 == 0 { (0.0, 0.02, 10) } else { (0.12, 0.007, 6) };
        railing.cylinder(steel, [(vec3(x, foot, 0.0), radius), (vec3(x, 0.96, 0.0), radius)], sides, 1);
    }
    railing
}

/// A flight of stairs that climbs from the origin along +z by `rise`, `width` along +x: treads with
/// nosings, risers, a soffit below, and a railing on its left.
#[must_use]
pub fn stair_flight(width: f32, run: f32, rise: f32, steps: u32) -> Mesh {
    let mut flight = empty();
    let (depth, height) = (run / steps as f32, rise / steps as f32);
    for i in 0..steps {
        let (y, z) = (height * i as f32, depth * i as f32);
        let concrete = Finish::Concrete;
        flight.quad(concrete.surface(), vec3(width, y, z), Vec3::NEG_X * width, Vec3::Y * height, WHOLE);
        slab(&mut flight, concrete, vec2(0.0, z), vec2(width, z + depth), y + height, false, WHOLE);
        let nose =
            [vec3(0.01, y + height + 0.0005, z + 0.005), vec3(width - 0.01, y + height + 0.004, z + 0.04)];
        block(&mut flight, Finish::Steel, nose[0], nose[1]);
    }
    // The slanted slab below, and its flanks, a hand's breadth under the steps' inner edges.
    let slope = vec3(0.0, rise, run);
    let under = vec3(0.0, -0.15, 0.0);
    flight.quad(Finish::Concrete.surface(), under, Vec3::X * width, slope, WHOLE);
    flight.quad(Finish::Concrete.surface(), under, slope, Vec3::Y * 0.15, WHOLE);
    flight.quad(Finish::Concrete.surface(), under + Vec3::X * width + slope, -slope, Vec3::Y * 0.15, WHOLE);
    for i in 0..steps {
        let foot = vec3(0.05, height * (i + 1) as f32, depth * (i as f32 + 0.5));
        let bar = [(foot, 0.008), (foot + Vec3::Y * 0.95, 0.008)];
        flight.cylinder(Finish::Steel.surface(), bar, 6, 1);
    }
    let first = vec3(0.05, height + 0.95 - height * 0.5, 0.0);
    let rail = [(first, 0.025), (first + slope, 0.025)];
    flight.closed_cylinder(Finish::Wood.surface(), rail, 10, 1);
    flight
}

/// The T-bars of a suspended ceiling over the rectangle from `min` to `max` of x and z, below `y`.
pub fn ceiling_grid(mesh: &mut Mesh, min: Vec2, max: Vec2, y: f32, cell: Vec2) {
    let bars = ((max - min) / cell).ceil();
    let step = (max - min) / bars;
    for i in 1..bars.x as u32 {
        let x = min.x + step.x * i as f32;
        block(mesh, Finish::Steel, vec3(x - 0.012, y - 0.012, min.y), vec3(x + 0.012, y - 0.001, max.y));
    }
    for j in 1..bars.y as u32 {
        let z = min.y + step.y * j as f32;
        for i in 0..bars.x as u32 {
            let from = min.x + step.x * i as f32 + 0.0125;
            let to = min.x + step.x * (i + 1) as f32 - 0.0125;
            block(mesh, Finish::Steel, vec3(from, y - 0.011, z - 0.012), vec3(to, y - 0.001, z + 0.012));
        }
    }
}

/// Wainscot for a wall at z = 0, from the origin along +x, 0.95 high: a skirting board, raised and
/// bevelled panels, and a moulded rail.
#[must_use]
pub fn wainscot(length: f32) -> Mesh {
    let mut wainscot = empty();
    let panels = (length / 0.6).round().max(1.0) as u32;
    let wide = length / panels as f32;
    block(&mut wainscot, Finish::DarkWood, vec3(0.0, 0.0, 0.0), vec3(length, 0.12, 0.02));
    block(&mut wainscot, Finish::Wood, vec3(0.0, 0.121, 0.0), vec3(length, 0.90, 0.01));
    let profile = [
        vec2(0.0, 0.905),
        vec2(0.02, 0.91),
        vec2(0.035, 0.925),
        vec2(0.035, 0.94),
        vec2(0.02, 0.95),
        vec2(0.0, 0.95),
    ];
    wainscot.patch(Finish::DarkWood.surface(), [1, 5], |u, v| {
        let p = profile[(v * 5.0).round() as usize];
        Vertex { position: vec3(u * length, p.y, p.x), along: vec2(u, v) }
    });
    for i in 0..panels {
        // Nested rectangles: (distance from the panel's edge, height over the board).
        let rings = [(0.0, 0.011), (0.008, 0.020), (0.02, 0.020), (0.05, 0.012), (0.055, 0.016)];
        let (min, max) = (vec2(wide * i as f32 + 0.05, 0.19), vec2(wide * (i + 1) as f32 - 0.05, 0.85));
        let corner = |k: usize, ring: usize| {
            let (inset, z) = rings[ring];
            let (low, high) = (min + inset, max - inset);
            let p = [low, vec2(high.x, low.y), high, vec2(low.x, high.y)][k % 4];
            p.extend(z)
        };
        for k in 0..4 {
            wainscot.patch(Finish::Wood.surface(), [1, rings.len() as u32 - 1], |u, v| {
                let ring = (v * (rings.len() - 1) as f32).round() as usize;
                Vertex { position: corner(k + u as usize, ring), along: vec2(u, v) }
            });
        }
        let last = rings.len() - 1;
        let origin = corner(0, last);
        let (right, up) = (corner(1, last) - origin, corner(3, last) - origin);
        wainscot.quad(Finish::Wood.surface(), origin, right, up, WHOLE);
    }
    wainscot
}

/// A light switch or, if `socket`, a socket for a wall at z = 0, centred at the origin.
#[must_use]
pub fn switch(socket: bool) -> Mesh {
    let mut plate = empty();
    let surface = Finish::Porcelain.surface();
    block(&mut plate, Finish::Porcelain, vec3(-0.04, -0.04, 0.0005), vec3(0.04, 0.04, 0.010));
    if socket {
        let ring = [(vec3(0.0, 0.0, 0.0105), 0.022), (vec3(0.0, 0.0, 0.013), 0.020)];
        plate.cylinder(surface, ring, 20, 1);
        for x in [-0.008, 0.008] {
            let pin = [(vec3(x, 0.0, 0.0105), 0.003), (vec3(x, 0.0, 0.0115), 0.003)];
            plate.closed_cylinder(Finish::PlasticBlack.surface(), pin, 8, 1);
        }
    } else {
        block(&mut plate, Finish::Porcelain, vec3(-0.025, -0.03, 0.0105), vec3(0.025, 0.0, 0.016));
        block(&mut plate, Finish::Porcelain, vec3(-0.025, 0.001, 0.0105), vec3(0.025, 0.03, 0.013));
    }
    plate
}

/// A lit sign over a door, for a wall at z = 0, centred at the origin.
#[must_use]
pub fn exit_sign() -> Mesh {
    let mut sign = empty();
    let case = [vec3(-0.18, -0.09, 0.001), vec3(0.18, 0.09, 0.06)];
    sign.rounded_cuboid(Finish::Porcelain.surface(), case, 0.01, 2, [1, 1, 1]);
    // The letters' strokes, on a grid of six to a letter's height.
    let strokes: [&[(f32, f32, f32, f32)]; 4] = [
        &[(0., 0., 1., 6.), (1., 5., 3., 6.), (1., 2.5, 2.5, 3.5), (1., 0., 3., 1.)],
        &[(0., 0., 1., 2.), (2., 0., 3., 2.), (1., 2., 2., 4.), (0., 4., 1., 6.), (2., 4., 3., 6.)],
        &[(1., 0., 2., 6.)],
        &[(1., 0., 2., 5.), (0., 5., 3., 6.)],
    ];
    for (i, letter) in strokes.iter().enumerate() {
        for &(left, low, right, high) in *letter {
            let scale = 0.018;
            let x = -0.14 + 0.075 * i as f32;
            block(
                &mut sign,
                Finish::SignalRed,
                vec3(x + left * scale, (low - 3.0) * scale, 0.0605),
                vec3(x + right * scale, (high - 3.0) * scale, 0.064),
            );
        }
    }
    sign
}

/// Adds `part` to a wall at `at` that faces `facing` (a unit vector along x or z).
pub fn hang(mesh: &mut Mesh, part: &Mesh, at: Vec3, facing: Vec3) {
    mesh.append(part, placed(at, libm::atan2f(facing.x, facing.z) / TAU));
}
