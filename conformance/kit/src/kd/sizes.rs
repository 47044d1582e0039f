//! Sessions of `saarcor-kd` about the sizes that people build: many triangles, long lists, deep trees, large planes.

use super::Kd;
use super::generated_scene::GeneratedScene;
use super::request::{END_OF_ADDRESSES, push_bounds, push_ray};
use crate::hex::push_write;
use crate::session::Requests;
use crate::sizes::{About, Extent, SizedSession, repeated};
use glam::Vec3;
use saarcor_model::host::{Aabb, Axis, KdTree, MAX_DEPTH, NODE_BYTES, Node, NodeRecord};
use saarcor_model::rays::{Query, Ray};
use saarcor_model::vm::HostAddr;
use saarcor_random::Random;

const STANDARD: &str = "kernel=moller-trumbore";
/// Shapes of a plan.
const SHAPES: u64 = 12;

/// All, in order.
pub fn sessions(extent: &Extent) -> Vec<SizedSession> {
    let new = |name: &str, about: About, requests: fn() -> Vec<u8>| {
        SizedSession::new(Kd, name, about, STANDARD, move |_| requests())
    };
    let mut all = vec![
        new(
            "sizes/far-addresses",
            ("HI-1", None, "Nodes, lists and triangles at addresses of each width, and over all borders."),
            far_addresses,
        ),
        new("sizes/writes", ("HI-1", None, "Writes of many lengths, over all borders."), writes),
        new("sizes/flush", ("HI-1", None, "After a flush memory is zero, wherever it was written."), flush),
        new("sizes/lists", ("KD-1", None, "Lists of up to ten thousand triangles."), lists),
        new("sizes/planes", ("KD-1", None, "Planes far out, close to zero, and with odd digits."), planes),
        new("sizes/deep-trees", ("KD-3", None, "Trees of each depth up to 64."), deep_trees),
        new(
            "sizes/ties",
            ("IS-2", None, "Of triangles at the same distance the lowest wins, however far apart."),
            ties,
        ),
    ];
    let far = new(
        "sizes/many-nodes",
        ("HI-1", None, "Twenty thousand triangles: nodes far from the root."),
        || many(9, 20_000, 1, 600),
    );
    all.push(far.large());
    for number in 0..SHAPES {
        let number = extent.seed.wrapping_mul(SHAPES).wrapping_add(number);
        let about = ("", None, "Scenes of hundreds of triangles.");
        let count = 50 << (number % 6);
        let made = move |_: &str| many(number, count, 1 + number as usize % 5, 200);
        all.push(SizedSession::new(Kd, &format!("shape/{number}"), about, STANDARD, made));
    }
    let rays = extent.long();
    let about = ("", None, "More rays than counters count.");
    all.push(SizedSession::new(Kd, "sizes/long", about, STANDARD, move |_| long(rays)).large());
    all
}

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// Asks for what a ray hits first, and whether it hits anything.
fn ask(text: &mut Vec<u8>, ray: &Ray) {
    push_ray(text, Query::Closest, ray);
    push_ray(text, Query::Any, ray);
}

/// Small triangles in a cube, and rays at them.
fn many(seed: u64, count: usize, leaf: usize, rays: usize) -> Vec<u8> {
    let mut random = Random::new(seed);
    let (triangles, size) = small_triangles(&mut random, count);
    let scene = GeneratedScene::with_leaves(&triangles, (leaf, 48), &mut random);
    let mut text = scene.requests();
    for _ in 0..rays {
        ask(&mut text, &ray_at(&mut random, &triangles, size));
    }
    text
}

/// Triangles in a cube, and its size.
fn small_triangles(random: &mut Random, count: usize) -> (Vec<[Vec3; 3]>, f32) {
    let size = (count as f32).cbrt().ceil();
    let place =
        |random: &mut Random, size: f32| Vec3::from_array(std::array::from_fn(|_| random.unit() * size));
    let triangle = |_| {
        let middle = place(random, size);
        std::array::from_fn(|_| middle + place(random, 0.15))
    };
    ((0..count).map(triangle).collect(), size)
}

fn ray_at(random: &mut Random, triangles: &[[Vec3; 3]], size: f32) -> Ray {
    let [a, b, c] = random.pick(triangles);
    let target = a * 0.25 + b * 0.25 + c * 0.5;
    let mut from: [f32; 3] = std::array::from_fn(|_| random.unit() * size);
    if random.percent(50) {
        from[random.below(3) as usize] = random.pick(&[-1.0, 2.0 * size]);
    }
    ray(from.into(), target - Vec3::from_array(from))
}

/// The image of a scene in pieces of many lengths.
fn writes() -> Vec<u8> {
    let mut random = Random::new(1);
    let mut text = Vec::new();
    for longest in [1, 3, 37, 1000, 4097, 65_537, 200_000] {
        let count = if longest < 30 { 40 } else { 4000 };
        let (triangles, size) = small_triangles(&mut random, count);
        let scene = GeneratedScene::with_leaves(&triangles, (2, 48), &mut random);
        let image = scene.image();
        text.extend_from_slice(b"flush\n");
        push_bounds(&mut text, &scene.tree.bounds);
        let mut place = 0;
        while place < image.len() {
            let len =
                (longest / 2 + random.below(longest as u64 / 2 + 1) as usize + 1).min(image.len() - place);
            push_write(&mut text, place as u32, &image[place..place + len]);
            place += len;
        }
        for _ in 0..100 {
            ask(&mut text, &ray_at(&mut random, &triangles, size));
        }
    }
    text
}

/// Writes a leaf as the root, with a list, all for triangles that lie somewhere.
fn leaf_of(text: &mut Vec<u8>, list: u32, triangles: &[u32]) {
    let root = NodeRecord::Leaf { list: HostAddr(list), count: triangles.len() as u32 };
    push_write(text, 0, &root.encode());
    let entries: Vec<u8> = triangles.iter().flat_map(|addr| addr.to_le_bytes()).collect();
    push_write(text, list, &entries);
}

fn push_triangle(text: &mut Vec<u8>, addr: u32, corners: &[[f32; 3]; 3]) {
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    push_write(text, addr, &bytes);
}

/// A triangle across z, of which most words are zero.
const FLAT: [[f32; 3]; 3] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

/// A tree of two leaves, of which the upper one lists a triangle, with one of its parts behind each power of two. Where
/// an address that lacks its upper bits leads, there lies another part of the same kind, so that a wrong walk ends.
fn far_addresses() -> Vec<u8> {
    let mut text = Vec::new();
    let at = |z: f32| FLAT.map(|[x, y, _]| [x, y, z]);
    let begin = |text: &mut Vec<u8>| {
        text.extend_from_slice(b"flush\n");
        push_bounds(text, &Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 4.0, 2.0) });
    };
    let down = ray(Vec3::new(1.0, 1.0, 5.0), Vec3::NEG_Z);
    for bit in 12..END_OF_ADDRESSES.ilog2() {
        for far_part in 0..3 {
            begin(&mut text);
            let behind = |part: u32| if part == far_part { 1 << bit } else { 0x400 };
            let [pair, list, triangle] = [0, 1, 2].map(|part| 0x800 + 0x100 * part + behind(part));
            let root = NodeRecord::Inner { axis: Axis::Z, split: 1.0, below: HostAddr(pair) };
            push_write(&mut text, 0, &root.encode());
            let (other, others_list) = (0xf00, 0xf80);
            for (pair, list) in [(0x800, others_list), (pair, list)] {
                for (child, count) in (0..).zip([0, 1]) {
                    let leaf = NodeRecord::Leaf { list: HostAddr(list), count };
                    push_write(&mut text, pair + NODE_BYTES * child, &leaf.encode());
                }
            }
            for (list, triangle) in [(0x900, other), (others_list, other), (list, triangle)] {
                push_write(&mut text, list, &triangle.to_le_bytes());
            }
            push_triangle(&mut text, 0xa00, &at(1.25));
            push_triangle(&mut text, other, &at(1.5));
            push_triangle(&mut text, triangle, &at(2.0));
            ask(&mut text, &down);
        }
    }
    for border in (12..END_OF_ADDRESSES.ilog2()).flat_map(|bit| [1 << bit, 3 << (bit - 1)]) {
        for before in [4, 12, 20, 32] {
            begin(&mut text);
            // The tree comes last: what goes astray does not make it one without an end.
            push_triangle(&mut text, border - before, &at(2.0));
            leaf_of(&mut text, 0x100, &[border - before]);
            ask(&mut text, &down);
        }
    }
    text
}

/// A triangle whose zeros are not written, where something else was written before a flush.
fn flush() -> Vec<u8> {
    let mut text = Vec::new();
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 4.0, 0.0) };
    let last = END_OF_ADDRESSES as u32;
    // Of each the last bytes of a page, and of what was written before.
    for end in [0x2000, 0x3000, 0x8000, 0x1_0000, 0x2_0000, 0x10_0000, 0x12_3000, 0x80_0000, last] {
        for back in [36, 0x400, 0xfdc, 0x1000 - 4] {
            let addr = end - back.max(36);
            text.extend_from_slice(b"flush\n");
            let begin = addr & !0xfff;
            push_write(&mut text, begin, &vec![0x3f; (addr + 36 - begin) as usize]);
            text.extend_from_slice(b"flush\n");
            push_bounds(&mut text, &bounds);
            leaf_of(&mut text, 0x100, &[addr]);
            push_write(&mut text, addr + 12, &4.0_f32.to_le_bytes());
            push_write(&mut text, addr + 28, &4.0_f32.to_le_bytes());
            ask(&mut text, &ray(Vec3::new(1.0, 1.0, 2.0), Vec3::NEG_Z));
            ask(&mut text, &ray(Vec3::new(3.0, 3.0, 2.0), Vec3::NEG_Z));
        }
    }
    text
}

/// Leaves of many triangles, one behind the other; the one in front stands anywhere in the list.
fn lists() -> Vec<u8> {
    let (mut random, mut text) = (Random::new(2), Vec::new());
    let most = 10_000;
    let triangles = 0x2_0000;
    text.extend_from_slice(b"flush\n");
    push_bounds(&mut text, &Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 4.0, most as f32) });
    for number in 0..most {
        let z = number as f32;
        push_triangle(&mut text, triangles + 36 * number, &FLAT.map(|[x, y, _]| [x, y, z]));
    }
    for count in [
        100, 127, 128, 129, 255, 256, 257, 511, 512, 513, 1000, 1023, 1025, 2047, 2049, 4095, 4096, 4097,
        8191, 8193, most,
    ] {
        for front in [count - 1, random.below(count.into()) as u32] {
            // The front one, the highest, takes the place of another.
            let mut order: Vec<u32> = (0..count).collect();
            order.swap(front as usize, count as usize - 1);
            let list: Vec<u32> = order.iter().map(|number| triangles + 36 * number).collect();
            leaf_of(&mut text, 0x1000, &list);
            ask(&mut text, &ray(Vec3::new(1.0, 1.0, 2.0 * most as f32), Vec3::NEG_Z));
        }
    }
    text
}

/// A chain of cells along an axis: a leaf below each plane, and the rest above it, or the other way round.
fn chain(axis: Axis, places: &[f32], upwards: bool) -> GeneratedScene {
    let turned = |x: f32, y: f32, z: f32| {
        let mut corner = [0.0; 3];
        for (place, number) in [x, y, z].into_iter().enumerate() {
            corner[(axis as usize + place) % 3] = number;
        }
        Vec3::from_array(corner)
    };
    let triangles: Vec<[Vec3; 3]> = places
        .iter()
        .zip(0..)
        .map(|(&x, number)| {
            let wide = 1.0 + (number % 3) as f32;
            [turned(x, 0.0, 0.0), turned(x, wide, 0.0), turned(x, 0.0, wide)]
        })
        .collect();
    let bounds = Aabb::around(triangles.iter().flatten().copied());
    let leaf = |number: usize| Node::Leaf { first: number as u32, count: 1 };
    let mut nodes = vec![leaf(0)];
    let mut at = 0;
    let last = places.len() - 1;
    for step in 0..last {
        // A triangle in the plane is listed below it.
        let (alone, split) =
            if upwards { (step, places[step]) } else { (last - step, places[last - step - 1]) };
        let children = nodes.len() as u32;
        nodes[at] = Node::Inner { axis, split, children };
        nodes.extend([leaf(alone); 2]);
        at = children as usize + usize::from(upwards);
        if !upwards {
            nodes.swap(children as usize, children as usize + 1);
            at = children as usize;
            nodes[at + 1] = leaf(alone);
        }
    }
    nodes[at] = leaf(if upwards { last } else { 0 });
    let refs = (0..places.len() as u32).collect();
    GeneratedScene { tree: KdTree { bounds, nodes, refs }, triangles }
}

/// Rays along a chain, from both ends and from between.
fn along(text: &mut Vec<u8>, axis: Axis, places: &[f32]) {
    let far = places[places.len() - 1].abs().max(places[0].abs()) * 2.0;
    let mut from = vec![-far, far];
    from.extend(places.windows(2).step_by(1 + places.len() / 6).map(|pair| pair[0].midpoint(pair[1])));
    for x in from {
        for side in [0.25, 1.25, 2.25, 5.0] {
            for direction in [1.0, -1.0] {
                let mut origin = [side * 0.4; 3];
                (origin[axis as usize], origin[(axis as usize + 1) % 3]) = (x, side * 0.5);
                let mut towards = [0.0; 3];
                towards[axis as usize] = direction;
                ask(text, &ray(origin.into(), towards.into()));
            }
        }
    }
}

fn chains(places: &[f32]) -> Vec<u8> {
    let mut text = Vec::new();
    for axis in Axis::ALL {
        for upwards in [false, true] {
            text.extend_from_slice(b"flush\n");
            text.extend(chain(axis, places, upwards).requests());
            along(&mut text, axis, places);
        }
    }
    text
}

fn planes() -> Vec<u8> {
    let far = [
        1.234_567_9e3,
        3.000_001e6,
        9.999_999e8,
        7e11,
        1.000_001e12,
        2.5e12,
        1e13,
        3e15,
        1e18,
        7e21,
        1e26,
        3e30,
    ];
    let close = [1e-3, 1.0000001e-6, 1e-12, 3e-20, 1e-30];
    let both = |numbers: &[f32]| {
        let mut all: Vec<f32> = numbers.iter().flat_map(|&number| [number, -number]).collect();
        all.push(0.0);
        all.sort_by(f32::total_cmp);
        all
    };
    let odd: Vec<f32> = (0..20).map(|number| 0.1 + number as f32 * 1.000_123_4).collect();
    [both(&far), both(&close), odd].iter().flat_map(|places| chains(places)).collect()
}

fn deep_trees() -> Vec<u8> {
    let depths =
        (2..=MAX_DEPTH).filter(|depth| depth % 7 == 2 || [15, 16, 31, 32, 33, 62, 63, 64].contains(depth));
    depths
        .flat_map(|depth| chains(&(0..=depth).map(|place| place as f32 * 2.0).collect::<Vec<_>>()))
        .collect()
}

/// The same triangle at two addresses or three, whose distances are bits of an address, in any order of the list.
fn ties() -> Vec<u8> {
    let mut text = Vec::new();
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 4.0, 0.0) };
    for bit in 6..24 {
        for low in [0x1000_u32, 0x1024, 0x2_0040] {
            let high = (low + (1 << bit).max(36)) & !3;
            if high + 36 > END_OF_ADDRESSES as u32 {
                continue;
            }
            for list in [[low, high], [high, low]] {
                text.extend_from_slice(b"flush\n");
                push_bounds(&mut text, &bounds);
                leaf_of(&mut text, 0x100, &list);
                list.iter().for_each(|&addr| push_triangle(&mut text, addr, &FLAT));
                ask(&mut text, &ray(Vec3::new(1.0, 1.0, 2.0), Vec3::NEG_Z));
            }
        }
    }
    text
}

/// So many short rays at one triangle.
fn long(rays: usize) -> Requests {
    let mut text = Vec::new();
    push_bounds(&mut text, &Aabb { min: Vec3::ZERO, max: Vec3::new(4.0, 4.0, 0.0) });
    leaf_of(&mut text, 0x100, &[0x200]);
    push_triangle(&mut text, 0x200, &FLAT);
    let hits = Ray { t_max: 4.0, ..ray(Vec3::new(1.0, 1.0, 2.0), Vec3::NEG_Z) };
    let misses = Ray { t_max: 1.0, ..hits };
    let of_rays = |rays: usize| {
        let mut text = Vec::new();
        for number in 0..rays {
            let query = if number % 3 == 0 { Query::Any } else { Query::Closest };
            push_ray(&mut text, query, if number % 7 == 0 { &misses } else { &hits });
        }
        text
    };
    Requests { first: text, ..repeated(rays, of_rays) }
}
