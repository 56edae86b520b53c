//! Points, sizes and pixels as they are typed.

use track::SeenPoint;

/// Numbers between commas.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is no number")),
    };
    text.split(',').map(number).collect()
}

/// `X,Y,U,V` or `X,Y,Z,U,V`.
pub(super) fn point(text: &str) -> Result<SeenPoint, String> {
    match numbers(text)?[..] {
        [x, y, u, v] => Ok(SeenPoint {
            at: [x, y, 0.0],
            pixel: [u, v],
        }),
        [x, y, z, u, v] => Ok(SeenPoint {
            at: [x, y, z],
            pixel: [u, v],
        }),
        _ => Err("four numbers X,Y,U,V or five X,Y,Z,U,V are needed".into()),
    }
}

/// `X,Y,X,Y`: two places on the table.
pub(super) fn places(text: &str) -> Result<[[f64; 2]; 2], String> {
    match numbers(text)?[..] {
        [x, y, other_x, other_y] => Ok([[x, y], [other_x, other_y]]),
        _ => Err("four numbers X,Y,X,Y are needed".into()),
    }
}

fn whole(text: &str, separator: char) -> Option<[usize; 2]> {
    let (first, second) = text.split_once(separator)?;
    Some([first.trim().parse().ok()?, second.trim().parse().ok()?])
}

/// `WIDTHxHEIGHT`.
pub(super) fn size(text: &str) -> Result<[usize; 2], String> {
    let size = whole(text, 'x').filter(|size| size.iter().all(|pixels| *pixels > 0));
    size.ok_or_else(|| "two whole numbers such as 1280x720 are needed".into())
}

/// `U,V`.
pub(super) fn pixel(text: &str) -> Result<[usize; 2], String> {
    whole(text, ',').ok_or_else(|| "two whole numbers such as 412,233 are needed".into())
}
