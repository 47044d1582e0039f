//! The image of a scene in host memory, wherever its bytes are.

use bytes::Bytes;
use saarcor_model::host::{HostImage, Registers};
use saarcor_model::vm::{self, HostAddr};

/// A [`HostImage`] whose bytes were made by this process, or lie in a file that is mapped into its memory. Copies share
/// them.
#[derive(Clone, Debug)]
pub struct Image {
    /// The bytes from host address 0 on.
    pub bytes: Bytes,
    /// What the driver writes into the chip.
    pub registers: Registers,
    /// Bytes of each region, as of [`HostImage::region_bytes`].
    pub region_bytes: [vm::Bytes; 5],
    /// Of the textures, bytes of the coarser levels of mip maps.
    pub mip_map_bytes: vm::Bytes,
    /// Which of the scene's triangles each triangle of the image is: little-endian numbers.
    pub(super) ids: Bytes,
}

/// Bytes of a number of [`Image::ids`].
const ID_BYTES: usize = size_of::<u32>();

impl From<HostImage> for Image {
    fn from(image: HostImage) -> Self {
        let HostImage { bytes, registers, region_bytes, mip_map_bytes, triangle_ids } = image;
        let ids: Vec<u8> = triangle_ids.into_iter().flat_map(u32::to_le_bytes).collect();
        Self { bytes: bytes.into(), registers, region_bytes, mip_map_bytes, ids: ids.into() }
    }
}

impl Image {
    /// Which of the scene's triangles each triangle of the image is.
    pub fn triangle_ids(&self) -> impl ExactSizeIterator<Item = u32> {
        self.ids.as_chunks::<ID_BYTES>().0.iter().map(|id| u32::from_le_bytes(*id))
    }

    /// The scene's index of the triangle at `addr`.
    ///
    /// # Panics
    /// If no triangle lies there.
    #[must_use]
    pub fn triangle_id(&self, addr: HostAddr) -> u32 {
        u32::from_le_bytes(self.ids.as_chunks().0[self.registers.triangle_index(addr) as usize])
    }
}
