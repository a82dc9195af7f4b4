//! Where blocks of pixels begin, in files whose tables of blocks were never filled.
//!
//! A program that ends before its time, or that cannot go back in what it writes, leaves zeros there. The blocks
//! themselves follow one another, and each says which one it is.

use super::read_exr::Exr;
use super::scan_exr::Blocks;
use super::source::ReadSeek;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use std::io::{self, SeekFrom};

/// For each part, where the blocks of its full resolution begin; 0 where one was not found.
pub(super) fn rebuild(exr: &Exr, reader: &mut dyn ReadSeek) -> Vec<Vec<u64>> {
    let count = |header: &Header| {
        let blocks = Blocks::of(header);
        blocks.with(0..header.layer_size.height()).end
    };
    let mut tables: Vec<Vec<u64>> =
        exr.parts.iter().map(|part| vec![0; part.readable().map_or(0, count)]).collect();
    let mut at = exr.first_block();
    // A file that ends in the middle of a block has no more of them.
    while let Ok(Some(next)) = one(exr, reader, at, &mut tables) {
        at = next;
    }
    tables
}

/// Notes the block that begins at `at`, and returns where the next one does; `None` if this is none.
fn one(exr: &Exr, reader: &mut dyn ReadSeek, at: u64, tables: &mut [Vec<u64>]) -> io::Result<Option<u64>> {
    if at >= exr.length {
        return Ok(None);
    }
    reader.seek(SeekFrom::Start(at))?;
    let index = if exr.multipart { number(reader)? } else { 0 };
    let Some((index, part)) = usize::try_from(index).ok().and_then(|i| Some((i, exr.parts.get(i)?))) else {
        return Ok(None);
    };
    let Some(header) = &part.header else { return Ok(None) };
    let blocks = Blocks::of(header);
    let place = match header.blocks {
        BlockDescription::ScanLines => {
            let row = i64::from(number(reader)?) - i64::from(header.own_attributes.layer_position.y());
            blocks.beginning([0, row])
        }
        BlockDescription::Tiles(tiles) => {
            let mut place = [0; 4];
            for value in &mut place {
                *value = i64::from(number(reader)?);
            }
            let [x, y, level_x, level_y] = place;
            let corner = [x * tiles.tile_size.0 as i64, y * tiles.tile_size.1 as i64];
            blocks.beginning(corner).filter(|_| [level_x, level_y] == [0, 0])
        }
    };
    let size = match header.deep {
        true => {
            let packed = long(reader)?.saturating_add(long(reader)?);
            // How large the samples are unpacked.
            long(reader)?;
            packed
        }
        false => u64::try_from(number(reader)?).unwrap_or(u64::MAX),
    };
    let next = reader.stream_position()?.saturating_add(size);
    if next > exr.length {
        return Ok(None);
    }
    if let Some(slot) = place.and_then(|place| tables[index].get_mut(place)) {
        *slot = at;
    }
    Ok(Some(next))
}

fn number(reader: &mut dyn ReadSeek) -> io::Result<i32> {
    let mut bytes = [0; 4];
    reader.read_exact(&mut bytes)?;
    Ok(i32::from_le_bytes(bytes))
}

fn long(reader: &mut dyn ReadSeek) -> io::Result<u64> {
    let mut bytes = [0; 8];
    reader.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}
