//! Dates and clock times in a column `time`.
//!
//! A date counts in seconds from 1970-01-01 00:00 UTC (a file without time zones: of its own clock), a clock time without a date from midnight.

/// Seconds of a date, a clock time or both; none where the text is neither.
///
/// # Errors
/// Where day and month can be exchanged.
pub(super) fn seconds(text: &str) -> Result<Option<f64>, String> {
    let text = text.trim();
    if !text.contains([':', '.', '-', '/']) || !text.starts_with(|c: char| c.is_ascii_digit()) {
        return Ok(None);
    }
    let (date, clock) = match text.find(['T', ' ']) {
        Some(at) => (&text[..at], text[at + 1..].trim()),
        None if text.contains(':') => ("", text),
        None => (text, ""),
    };
    // `08:15:00 PM` has no date.
    let (date, clock) = if date.contains(':') { ("", text) } else { (date, clock) };
    let days = if date.is_empty() { Some(0) } else { days(date)? };
    let of_day = if clock.is_empty() { Some(0.0) } else { of_day(clock) };
    Ok(days.zip(of_day).map(|(days, seconds)| 86_400.0 * days as f64 + seconds))
}

/// Days from 1970-01-01.
fn days(date: &str) -> Result<Option<i64>, String> {
    let Some(mark) = date.chars().find(|c| !c.is_ascii_digit()) else { return Ok(None) };
    let parts: Vec<&str> = date.split(mark).collect();
    let [first, second, third] = parts[..] else { return Ok(None) };
    let number = |part: &str| (part.len() <= 4).then(|| part.parse::<i64>().ok()).flatten();
    let (Some(a), Some(b), Some(c)) = (number(first), number(second), number(third)) else { return Ok(None) };
    let (year, month, day) = match mark {
        '-' | '/' | '.' if first.len() == 4 => (a, b, c),
        '.' if third.len() == 4 => (c, b, a),
        '-' | '/' if third.len() == 4 && a > 12 => (c, b, a),
        '-' | '/' if third.len() == 4 && b > 12 => (c, a, b),
        '-' | '/' if third.len() == 4 && a == b => (c, a, b),
        '-' | '/' if third.len() == 4 => {
            return Err(format!(
                "`{date}` is {third}-{second:0>2}-{first:0>2} or {third}-{first:0>2}-{second:0>2}; write dates as YYYY-MM-DD"
            ));
        }
        _ => return Ok(None),
    };
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return Ok(None);
    }
    // Days of the civil calendar (Hinnant): years begin in March, so that the leap day ends one.
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Ok(Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468))
}

/// Seconds from midnight, less the offset of a time zone.
fn of_day(clock: &str) -> Option<f64> {
    let (clock, zone) = match clock.find(['Z', 'z', '+', '-']) {
        Some(at) => (&clock[..at], clock[at..].trim_start_matches(['Z', 'z'])),
        None => (clock, ""),
    };
    let lower = clock.trim().to_lowercase();
    let (lower, half) = match (lower.strip_suffix("am"), lower.strip_suffix("pm")) {
        (Some(rest), _) => (rest.trim().to_owned(), Some(0.0)),
        (_, Some(rest)) => (rest.trim().to_owned(), Some(12.0)),
        _ => (lower, None),
    };
    let mut parts = lower.split(':');
    let whole = |part: &str, below: u32| part.parse::<u32>().ok().filter(|&n| n < below && part.len() <= 2);
    let hours = f64::from(whole(parts.next()?, 24)?);
    let minutes = f64::from(whole(parts.next()?, 60)?);
    let seconds = match parts.next() {
        Some(text) if text.starts_with(|c: char| c.is_ascii_digit()) => {
            text.replace(',', ".").parse::<f64>().ok().filter(|s| (0.0..61.0).contains(s))?
        }
        Some(_) => return None,
        None => 0.0,
    };
    let hours = match half {
        Some(half) if (1.0..=12.0).contains(&hours) => hours % 12.0 + half,
        Some(_) => return None,
        None => hours,
    };
    if parts.next().is_some() {
        return None;
    }
    let offset = match zone {
        "" => 0.0,
        zone => {
            let digits: String = zone[1..].chars().filter(|&c| c != ':').collect();
            let (hours, minutes) = digits.split_at_checked(2)?;
            let minutes = if minutes.is_empty() { 0 } else { whole(minutes, 60)? };
            let size = 3600.0 * f64::from(whole(hours, 24)?) + 60.0 * f64::from(minutes);
            if zone.starts_with('-') { -size } else { size }
        }
    };
    Some(3600.0 * hours + 60.0 * minutes + seconds - offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_clock_times() {
        // 2024-03-11 is day 19 793.
        let day = 19_793.0 * 86_400.0;
        for (text, expected) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2024-03-11", day),
            ("2024-03-11T08:15:00", day + 29_700.0),
            ("2024-03-11 08:15:00.250", day + 29_700.25),
            ("2024-03-11T08:15:00+01:00", day + 26_100.0),
            ("11.03.2024 08:15:00", day + 29_700.0),
            ("11.03.2024 08:15", day + 29_700.0),
            ("03/25/2024 8:15 PM", day + 14.0 * 86_400.0 + 72_900.0),
            ("2000-02-29", 11_016.0 * 86_400.0),
            ("08:15:00,5", 29_700.5),
            ("12:05 am", 300.0),
        ] {
            let found = seconds(text).unwrap().unwrap();
            assert!((found - expected).abs() < 1e-6, "{text}: {found} {expected}");
        }
        for other in ["abc", "12", "25:00", "2024-13-01", "1.5.2", "8:15:xx", ""] {
            assert_eq!(seconds(other), Ok(None), "{other}");
        }
        assert_eq!(
            seconds("03/11/2024 08:15").unwrap_err(),
            "`03/11/2024` is 2024-11-03 or 2024-03-11; write dates as YYYY-MM-DD"
        );
    }
}
