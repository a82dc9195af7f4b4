//! Sizes and points as they are written on a command line.

use super::SceneError;

/// Parses `640x480` as columns and rows. [`super::render`] checks the size.
pub fn parse_size(text: &str) -> Result<[usize; 2], SceneError> {
    let error =
        || SceneError::BadText { text: text.into(), expected: "columns, an x and rows, for example 640x480" };
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(error)?;
    let number = |t: &str| t.trim().parse::<usize>().map_err(|_| error());
    Ok([number(width)?, number(height)?])
}

/// Parses `1,2,3`, also with spaces, as a point with finite coordinates.
pub fn parse_point(text: &str) -> Result<[f64; 3], SceneError> {
    let error = || SceneError::BadText {
        text: text.into(),
        expected: "three numbers with commas between, for example 1,-2.5,0",
    };
    let parts: Vec<&str> = match text.contains(',') {
        true => text.split(',').collect(),
        false => text.split_whitespace().collect(),
    };
    let mut point = [0.0; 3];
    if parts.len() != point.len() {
        return Err(error());
    }
    for (coordinate, part) in point.iter_mut().zip(parts) {
        *coordinate = part.trim().parse().ok().filter(|c: &f64| c.is_finite()).ok_or_else(error)?;
    }
    Ok(point)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_columns_by_rows() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        assert_eq!(parse_size(" 7 X 9 "), Ok([7, 9]));
        for text in ["", "640", "640x", "x480", "-1x5", "1.5x2", "1x2x3", "99999999999999999999x1"] {
            let error = parse_size(text).expect_err(text);
            assert!(error.hint().contains("640x480"), "{error}");
        }
    }

    #[test]
    fn points_are_three_finite_numbers() {
        assert_eq!(parse_point("1,2,3"), Ok([1.0, 2.0, 3.0]));
        assert_eq!(parse_point(" -1.5 , 2e1, .25"), Ok([-1.5, 20.0, 0.25]));
        assert_eq!(parse_point("1 2 3"), Ok([1.0, 2.0, 3.0]));
        for text in ["", "1,2", "1,2,3,4", "1,,3", "a,b,c", "nan,0,0", "inf,0,0", "1 2"] {
            let error = parse_point(text).expect_err(text);
            assert!(error.to_string().contains("1,-2.5,0"), "{error}");
        }
    }
}
