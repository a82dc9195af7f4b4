//! Textures larger than memory: tiles in a temporary file, and a cache of those that were looked at last.
//!
//! Peachey's "Texture on Demand" (1990) is the model: what is looked at is a small part of what there is, so a
//! bound on memory costs little as long as it holds what one stretch of the picture needs.

use crate::image::{ImageError, temporary_folder};
use quick_cache::Weighter;
use quick_cache::sync::Cache;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A tile of a store: the store's number, and where in it the tile begins.
type Key = (u64, u64);

#[derive(Clone, Debug)]
struct Bytes;

impl Weighter<Key, Arc<[u8]>> for Bytes {
    fn weight(&self, _: &Key, tile: &Arc<[u8]>) -> u64 {
        tile.len() as u64
    }
}

/// The tiles in memory, of all textures of a program.
#[derive(Debug)]
pub struct Tiles {
    cache: Cache<Key, Arc<[u8]>, Bytes>,
}

impl Default for Tiles {
    fn default() -> Tiles {
        // The number of tiles is only a first guess; the bound is on bytes, and is set before a run.
        Tiles { cache: Cache::with_weighter(1 << 10, 64 << 20, Bytes) }
    }
}

impl Tiles {
    /// How many bytes of tiles stay in memory.
    pub fn allow(&self, bytes: u64) {
        if self.cache.capacity() != bytes {
            self.cache.set_capacity(bytes);
        }
    }
}

/// A temporary file for the tiles of one texture. It has no name, so it goes when the last user does.
#[derive(Debug)]
pub(super) struct Store {
    number: u64,
    file: Mutex<File>,
    tiles: Arc<Tiles>,
    /// The first tile that could not be read.
    failed: OnceLock<ImageError>,
}

fn failure(what: &str, error: &io::Error) -> ImageError {
    ImageError::io(what, "a temporary file for textures", error)
        .hint("Set another folder with `TMPDIR`, or avoid the file with more memory (`--texture-memory`).")
}

impl Store {
    /// A store that keeps its tiles in this cache.
    pub fn new(tiles: &Arc<Tiles>) -> Result<Store, ImageError> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let file = tempfile::tempfile_in(temporary_folder()).map_err(|error| failure("make", &error))?;
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Ok(Store { number, file: Mutex::new(file), tiles: Arc::clone(tiles), failed: OnceLock::new() })
    }

    /// Writes a tile, where it begins in the file.
    pub fn put(&self, at: u64, tile: &[u8]) -> Result<(), ImageError> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file.seek(SeekFrom::Start(at)).and_then(|_| file.write_all(tile));
        written.map_err(|error| failure("write", &error))
    }

    /// Tells whether every tile could be read so far. Look-ups themselves do not fail: a tile that cannot be read is
    /// black, and the run that looked at it is void.
    ///
    /// # Errors
    /// The first failure.
    pub fn sound(&self) -> Result<(), ImageError> {
        self.failed.get().map_or(Ok(()), |error| Err(error.clone()))
    }

    fn read(&self, at: u64, size: usize) -> io::Result<Arc<[u8]>> {
        // Made where it will stay: a second copy of each would break memory into pieces.
        let mut tile: Arc<[u8]> = std::iter::repeat_n(0, size).collect();
        if let Some(bytes) = Arc::get_mut(&mut tile) {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(bytes)?;
        }
        Ok(tile)
    }

    /// The tile of so many bytes that begins there.
    #[inline]
    pub fn tile<'n>(&self, at: u64, size: usize, near: &'n mut Near) -> &'n [u8] {
        let key = (self.number, at);
        // Neighbouring tiles fall into different seats; so do those of levels side by side.
        let seat = &mut near.0[(at / size as u64) as usize % NEAR];
        match seat {
            Some((of, _)) if *of == key => {}
            _ => *seat = Some((key, self.fetch(key, size))),
        }
        seat.as_ref().map_or(&[], |(_, tile)| tile)
    }

    #[cold]
    fn fetch(&self, key: Key, size: usize) -> Arc<[u8]> {
        let tile = self.tiles.cache.get_or_insert_with(&key, || self.read(key.1, size));
        tile.unwrap_or_else(|error| {
            // Only the first is told.
            let _ = self.failed.set(failure("read", &error));
            vec![0; size].into()
        })
    }
}

/// How many tiles a look-up remembers.
const NEAR: usize = 16;

/// The tiles at which the last look-ups of a thread looked: they are at hand without asking the cache.
#[derive(Debug, Default)]
pub struct Near([Option<(Key, Arc<[u8]>)>; NEAR]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_come_back_however_small_the_cache() {
        for bound in [0, 100, 1 << 20] {
            let tiles = Arc::new(Tiles::default());
            tiles.allow(bound);
            let (a, b) = (Store::new(&tiles).unwrap(), Store::new(&tiles).unwrap());
            for i in 0..40_u8 {
                a.put(u64::from(i) * 64, &[i; 64]).unwrap();
                b.put(u64::from(i) * 64, &[100 + i; 64]).unwrap();
            }
            let mut near = Near::default();
            for i in (0..40_u8).chain((0..40).rev()) {
                assert_eq!(a.tile(u64::from(i) * 64, 64, &mut near), [i; 64]);
                assert_eq!(b.tile(u64::from(i) * 64, 64, &mut near), [100 + i; 64]);
            }
            assert!(tiles.cache.weight() <= bound, "{bound}: {}", tiles.cache.weight());
            assert!(a.sound().is_ok());
        }
    }

    #[test]
    fn a_tile_that_cannot_be_read_is_told() {
        let tiles = Arc::new(Tiles::default());
        let store = Store::new(&tiles).unwrap();
        store.put(0, &[1; 64]).unwrap();
        assert_eq!(store.tile(64, 64, &mut Near::default()), [0; 64]);
        let error = store.sound().unwrap_err();
        assert!(error.message.contains("temporary file for textures"), "{error}");
    }
}
