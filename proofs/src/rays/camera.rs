//! Theorems of ray generation (RG-1 to RG-3).

use crate::draw::{self, WORDS};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::host::Camera;
use saarcor_model::rays::{Frame, SURFACE_OFFSET, ray_from_surface};

/// Pixels a side: the least, around tiles of 4 and 8, and large ones.
static SIDES: [u32; 8] = [1, 2, 4, 5, 8, 9, 17, 0x1_0001];

/// A camera at the origin that looks along −z, with an angle of 90 degrees from bottom to top.
fn camera() -> Camera {
    Camera {
        eye: [0.5, 2.0, -3.0].into(),
        dir: [0.0, 0.0, -1.0].into(),
        up: [0.0, 1.0, 0.0].into(),
        fov_y_deg: 90.0,
    }
}

/// The lane and the packet of a pixel, by the definition of RG-2, and what the packet then says of the lane.
fn pixel_is_there<const N: usize>(side: u32, frame: &Frame, (x, y): (u32, u32)) -> (u32, Option<(u32, u32)>) {
    let columns = frame.width().div_ceil(side);
    let packet = y / side * columns + x / side;
    let lane = (y % side * side + x % side) as usize;
    (packet, frame.pixels::<N>(packet)[lane])
}

theorems! {
    /// Each pixel of a picture of any size is the lane of its place in an 8 x 8 tile, row by row, and tiles follow
    /// one another in scan order; the same holds of tiles of 1, 2 x 2 and 4 x 4; lanes beyond the picture's edge
    /// have no pixel, and there are as many packets as tiles.
    #[
        "RG-2", not_for_kani "a camera has a tangent",
        covers ["the last pixel", "a tile beyond the right edge", "a tile beyond the lower edge", "from lane 16 on", "from packet 65536 on"]
    ]
    fn pixels_are_lanes_of_tiles_in_scan_order(s) {
        let (width, height) = (s.value("width", 1..=0x1_0001, &SIDES), s.value("height", 1..=0x1_0001, &SIDES));
        let frame = Frame::new(&camera(), width, height);
        let near = |place: u32, side: u32| if place < 9 { place % side } else { (side - 1).saturating_sub(place % side) };
        let (x, y) = (near(s.value("column", 0..=0x1_0000, &WORDS[..12]), width), near(s.value("row", 0..=0x1_0000, &WORDS[..12]), height));
        let (log, side) = match s.value("log2 of the tile's side", 0..=3_u32, &[0, 1, 2, 3]) {
            log @ 0..=2 => (log, 1 << log),
            log => (log, 8),
        };
        let tiles = |length: u32| length.div_ceil(side);
        assume!(u64::from(tiles(width)) * u64::from(tiles(height)) <= u64::from(u32::MAX));
        let (packet, pixel) = match log {
            0 => pixel_is_there::<1>(side, &frame, (x, y)),
            1 => pixel_is_there::<4>(side, &frame, (x, y)),
            2 => pixel_is_there::<16>(side, &frame, (x, y)),
            _ => pixel_is_there::<64>(side, &frame, (x, y)),
        };
        cover!(s, "the last pixel", x + 1 == width && y + 1 == height);
        cover!(s, "a tile beyond the right edge", width % side != 0);
        cover!(s, "a tile beyond the lower edge", height % side != 0);
        cover!(s, "from lane 16 on", side == 8 && y % 8 >= 2);
        cover!(s, "from packet 65536 on", packet >= 0x1_0000);
        check_eq!((frame.width(), frame.height()), (width, height), "the size asked for");
        check_eq!(pixel, Some((x, y)), "packet {packet} of {width} x {height} pixels");
        let packets = match log {
            0 => frame.packets::<1>(),
            1 => frame.packets::<4>(),
            2 => frame.packets::<16>(),
            _ => frame.packets::<64>(),
        };
        check_eq!(packets, tiles(width) * tiles(height), "packets of {width} x {height} pixels");
        if side == 8 {
            // No pixel but those of the tile, and those once: each lane has its own.
            for (lane, pixel) in frame.pixels::<64>(packet).into_iter().enumerate() {
                let (column, row) = (x / 8 * 8 + lane as u32 % 8, y / 8 * 8 + lane as u32 / 8);
                check_eq!(pixel, (column < width && row < height).then_some((column, row)), "lane {lane} of packet {packet}");
            }
            let rays = frame.primary_packet::<64>(packet);
            for (lane, pixel) in frame.pixels::<64>(packet).into_iter().enumerate() {
                check_eq!(rays.is_active(lane), pixel.is_some(), "lane {lane} of packet {packet}");
                let own = pixel.is_none_or(|(column, row)| rays.ray(lane) == frame.primary_ray(column, row));
                check!(own, "lane {lane} of packet {packet}: {:?}", rays.ray(lane));
            }
        }
    }

    /// A primary ray starts at the eye, goes to infinity, and its unit direction is that to the centre of its
    /// pixel: columns count to the right, along dir x up, and rows downwards; pixels are square.
    #["RG-1", not_for_kani "it is arithmetic in floating point", covers ["the first pixel", "the last pixel", "wider than high", "one pixel"]]
    fn primary_ray_goes_through_its_pixel(s) {
        let (width, height) = (s.value("width", 1..=4096, &SIDES[..7]), s.value("height", 1..=4096, &SIDES[..7]));
        let (x, y) = (s.value("column", 0..=4095, &WORDS[..9]) % width, s.value("row", 0..=4095, &WORDS[..9]) % height);
        let camera = camera();
        let turned = draw::flag(s, "turned");
        // The picture's right is +x, or, looking along +x with z up, −y.
        let camera = if turned { Camera { dir: [1.0, 0.0, 0.0].into(), up: [0.0, 0.0, 1.0].into(), ..camera } } else { camera };
        let frame = Frame::new(&camera, width, height);
        cover!(s, "the first pixel", x == 0 && y == 0);
        cover!(s, "the last pixel", x + 1 == width && y + 1 == height);
        cover!(s, "wider than high", width > height);
        cover!(s, "one pixel", width == 1 && height == 1);
        let ray = frame.primary_ray(x, y);
        check!(ray.origin == camera.eye && ray.t_min == 0.0 && ray.t_max == f32::INFINITY, "{ray:?}");
        // The tangent of 45 degrees is 1: in units of half the height.
        let over = |number: u32, of: u32| f64::from(2 * number + 1) / f64::from(of);
        let right = (over(x, width) - 1.0) * f64::from(width) / f64::from(height);
        let up = 1.0 - over(y, height);
        let length = (1.0 + right * right + up * up).sqrt();
        let plain = if turned { [1.0, -right, up] } else { [right, up, -1.0] };
        for axis in 0..3 {
            let (found, expected) = (f64::from(ray.direction[axis]), plain[axis] / length);
            // The angle's tangent, the sums, the length and the quotient: ten roundings of numbers up to 2, or, in a
            // wide picture, up to twice its width.
            let largest = (f64::from(width) / f64::from(height)).max(1.0);
            check!((found - expected).abs() <= 10.0 * largest * f64::from(f32::EPSILON), "pixel {x}, {y} of {width} x {height}: {:?}, not {plain:?} / {length}", ray.direction);
        }
        let pixel = f64::from(frame.pixel_width()) * f64::from(height) / 2.0;
        check!((pixel - 1.0).abs() <= 4.0 * f64::from(f32::EPSILON), "a pixel is {} wide", frame.pixel_width());
    }

    /// A ray from a surface starts 64 units of 2^-23 of the largest coordinate off the surface, along the normal
    /// on the side to which it goes, in the plane on the normal's side; it keeps its direction, and has the range
    /// from 0 to what is asked for.
    #["RG-3", not_for_kani "it multiplies in floating point", covers ["before", "behind", "in the plane", "large coordinates"]]
    fn rays_start_off_the_surface_they_leave(s) {
        let axis = s.value("axis of the normal", 0..=2, &WORDS[..3]) as usize;
        let upwards = draw::flag(s, "normal upwards");
        let across = [-2.0_f32, -0.0, 0.0, 2.0, f32::MIN_POSITIVE, -f32::MIN_POSITIVE][s.value("direction across", 0..=5, &WORDS[..6]) as usize];
        let exponent = s.value("exponent of the scale + 20", 0..=60, &WORDS[..40]) as i32 - 20;
        let end = [0.0, 1.0, f32::INFINITY][s.value("end", 0..=2, &WORDS[..3]) as usize];
        let scale = 2.0_f32.powi(exponent);
        let mut normal = [0.0; 3];
        normal[axis] = if upwards { 1.0 } else { -1.0 };
        let mut direction = [0.5; 3];
        direction[axis] = across;
        let point = [scale, -scale, scale / 2.0];
        let ray = ray_from_surface(point.into(), scale, normal.into(), direction.into(), end);
        // A direction of zero across the normal goes to the normal's side.
        let along = if across == 0.0 { upwards } else { across > 0.0 };
        cover!(s, "before", across != 0.0 && along == upwards);
        cover!(s, "behind", along != upwards);
        cover!(s, "in the plane", across == 0.0);
        cover!(s, "large coordinates", scale > 1.0e5);
        check_eq!(SURFACE_OFFSET, 64.0 / (1 << 23) as f32, "of the largest coordinate");
        // 2^-17 of a power of two: the sum is exact.
        let offset = scale / (1 << 17) as f32;
        let mut start = point;
        start[axis] += if along { offset } else { -offset };
        check_eq!(ray.origin.to_array(), start, "from {point:?}, normal {normal:?}, direction {direction:?}");
        check!(ray.direction.to_array() == direction && ray.t_min == 0.0 && ray.t_max == end, "{ray:?}");
    }
}
