//! The numbers of textures, as bytes of a tile.

/// A number that tiles hold, least significant byte first.
pub(super) trait Number: Copy + Default + Send + Sync + 'static {
    /// Its bytes.
    const SIZE: usize;
    /// Writes it behind what is there.
    fn put(self, out: &mut Vec<u8>);
    /// Reads it from the beginning of these bytes.
    fn get(bytes: &[u8]) -> Self;
}

macro_rules! number {
    ($t:ty) => {
        impl Number for $t {
            const SIZE: usize = size_of::<$t>();
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            #[inline]
            fn get(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or(Self::default(), |bytes| Self::from_le_bytes(*bytes))
            }
        }
    };
}
number!(f32);
number!(f64);
