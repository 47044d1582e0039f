//! Pictures: a frame through any memory.

use crate::dispatch::{ForPackets, ForWays, with_packets, with_ways};
use crate::trace::TraceOptions;
use crate::world::World;
use glam::Vec3;
use image::RgbImage;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::host::Registers;
use saarcor_model::rays::{Frame, Pipeline, RayCounts};
use saarcor_model::vm::{CacheConfig, Counters, Directory, Memory, Observed, VirtualMemory, WholeScene};

/// A picture and the rays that it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The pixels, 8 bits a colour, 255 for 1.0 and above.
    pub pixels: RgbImage,
    /// The rays.
    pub rays: RayCounts,
}

/// The picture of a frame of the world's path, its packets one after the other in scan order.
///
/// # Panics
/// If the path does not have the frame.
#[must_use]
pub fn picture(memory: &mut dyn Memory, world: &World, frame: usize, options: &TraceOptions) -> Picture {
    let (width, height) = options.resolution;
    let frame = Frame::new(&world.path[frame], width, height);
    let mut memory = Observed::by_nobody(memory);
    let registers = &world.image.registers;
    let work = Render { memory: &mut memory, registers, frame, max_bounces: options.max_bounces };
    with_packets(options.packet, work)
}

/// The picture without virtual memory.
#[must_use]
pub fn through_whole_scene(world: &World, frame: usize, options: &TraceOptions) -> Picture {
    picture(&mut WholeScene(&world.image.bytes), world, frame, options)
}

/// The picture through a virtual memory that is empty at first, and the counters of that.
#[must_use]
pub fn through_virtual_memory(
    world: &World,
    frame: usize,
    options: &TraceOptions,
    cache: CacheConfig,
) -> (Picture, Counters) {
    with_ways(cache.geometry.ways(), RenderThrough { world, frame, options, cache })
}

struct RenderThrough<'a> {
    world: &'a World,
    frame: usize,
    options: &'a TraceOptions,
    cache: CacheConfig,
}

impl ForWays for RenderThrough<'_> {
    type Output = (Picture, Counters);

    fn run<const WAYS: usize>(self) -> Self::Output {
        let Self { world, frame, options, cache } = self;
        let mut memory = VirtualMemory::new(Directory::<WAYS>::new(cache), &world.image.bytes);
        let picture = picture(&mut memory, world, frame, options);
        (picture, memory.directory.counters)
    }
}

struct Render<'a, 'm> {
    memory: &'a mut Observed<&'m mut dyn Memory>,
    registers: &'a Registers,
    frame: Frame,
    max_bounces: u32,
}

impl ForPackets for Render<'_, '_> {
    type Output = Picture;

    fn run<const N: usize>(self) -> Picture {
        let Self { memory, registers, frame, max_bounces } = self;
        let mut pixels = RgbImage::new(frame.width(), frame.height());
        let mut pipeline = Pipeline::<N, _>::with(FilteredIntersection::default(), max_bounces);
        for packet in 0..frame.packets::<N>() {
            let colours = pipeline.render(memory, registers, &frame, packet);
            let places = frame.pixels::<N>(packet);
            let placed: [_; N] = std::array::from_fn(|ray| (places[ray], colours[ray]));
            put_pixels(&mut pixels, &placed);
        }
        Picture { pixels, rays: pipeline.rays }
    }
}

/// Puts colours where they belong, as far as that is in the picture.
pub(crate) fn put_pixels(pixels: &mut RgbImage, placed: &[(Option<(u32, u32)>, Vec3)]) {
    for &(place, colour) in placed {
        if let Some((x, y)) = place {
            pixels.put_pixel(x, y, image::Rgb(eight_bits(colour)));
        }
    }
}

/// A colour of 0 to 1, rounded to 0 to 255.
fn eight_bits(colour: Vec3) -> [u8; 3] {
    // The cast takes what lies outside to the nearest end.
    colour.to_array().map(|part| (part * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_clamped_and_rounded() {
        assert_eq!(eight_bits(Vec3::new(-1.0, 0.5, 7.0)), [0, 128, 255]);
    }
}
