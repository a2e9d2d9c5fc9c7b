// SPDX-License-Identifier: BSD-3-Clause
#include "html_entities.h"

#include <unicode/locid.h>
#include <unicode/uchar.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <sstream>
#include <string>

#include "unicode.h"

namespace tsg::language {
namespace {

// HTML 4.01, section 24. The first list counts up from U+00A0.
constexpr const char* kLatin1Names =
    "nbsp iexcl cent pound curren yen brvbar sect uml copy ordf laquo not shy reg macr deg plusmn "
    "sup2 sup3 acute micro para middot cedil sup1 ordm raquo frac14 frac12 frac34 iquest Agrave "
    "Aacute Acirc Atilde Auml Aring AElig Ccedil Egrave Eacute Ecirc Euml Igrave Iacute Icirc Iuml "
    "ETH Ntilde Ograve Oacute Ocirc Otilde Ouml times Oslash Ugrave Uacute Ucirc Uuml Yacute THORN "
    "szlig agrave aacute acirc atilde auml aring aelig ccedil egrave eacute ecirc euml igrave "
    "iacute icirc iuml eth ntilde ograve oacute ocirc otilde ouml divide oslash ugrave uacute "
    "ucirc "
    "uuml yacute thorn yuml";
// These, like those above, may lack their semicolon.
constexpr const char* kMarkupNames =
    "quot 22 QUOT 22 amp 26 AMP 26 lt 3c LT 3c gt 3e GT 3e COPY a9 REG ae";
constexpr const char* kOtherNames =
    "apos 27 OElig 152 oelig 153 Scaron 160 scaron 161 Yuml 178 fnof 192 circ 2c6 tilde 2dc "
    "Alpha 391 Beta 392 Gamma 393 Delta 394 Epsilon 395 Zeta 396 Eta 397 Theta 398 Iota 399 "
    "Kappa 39a Lambda 39b Mu 39c Nu 39d Xi 39e Omicron 39f Pi 3a0 Rho 3a1 Sigma 3a3 Tau 3a4 "
    "Upsilon 3a5 Phi 3a6 Chi 3a7 Psi 3a8 Omega 3a9 alpha 3b1 beta 3b2 gamma 3b3 delta 3b4 "
    "epsilon 3b5 zeta 3b6 eta 3b7 theta 3b8 iota 3b9 kappa 3ba lambda 3bb mu 3bc nu 3bd xi 3be "
    "omicron 3bf pi 3c0 rho 3c1 sigmaf 3c2 sigma 3c3 tau 3c4 upsilon 3c5 phi 3c6 chi 3c7 psi 3c8 "
    "omega 3c9 thetasym 3d1 upsih 3d2 piv 3d6 ensp 2002 emsp 2003 thinsp 2009 zwnj 200c zwj 200d "
    "lrm 200e rlm 200f ndash 2013 mdash 2014 lsquo 2018 rsquo 2019 sbquo 201a ldquo 201c "
    "rdquo 201d bdquo 201e dagger 2020 Dagger 2021 bull 2022 hellip 2026 permil 2030 prime 2032 "
    "Prime 2033 lsaquo 2039 rsaquo 203a oline 203e frasl 2044 euro 20ac image 2111 weierp 2118 "
    "real 211c trade 2122 TRADE 2122 alefsym 2135 larr 2190 uarr 2191 rarr 2192 darr 2193 "
    "harr 2194 crarr 21b5 lArr 21d0 uArr 21d1 rArr 21d2 dArr 21d3 hArr 21d4 forall 2200 part 2202 "
    "exist 2203 empty 2205 nabla 2207 isin 2208 notin 2209 ni 220b prod 220f sum 2211 minus 2212 "
    "lowast 2217 radic 221a prop 221d infin 221e ang 2220 and 2227 or 2228 cap 2229 cup 222a "
    "int 222b there4 2234 sim 223c cong 2245 asymp 2248 ne 2260 equiv 2261 le 2264 ge 2265 "
    "sub 2282 sup 2283 nsub 2284 sube 2286 supe 2287 oplus 2295 otimes 2297 perp 22a5 sdot 22c5 "
    "lceil 2308 rceil 2309 lfloor 230a rfloor 230b lang 27e8 rang 27e9 loz 25ca spades 2660 "
    "clubs 2663 hearts 2665 diams 2666";

struct Entity {
  UChar32 code_point = 0;
  bool needs_semicolon = true;
};

std::map<std::string, Entity> buildEntities() {
  std::map<std::string, Entity> entities;
  std::string name;
  UChar32 code_point = 0xa0;
  for (std::istringstream stream(kLatin1Names); stream >> name; ++code_point) {
    entities[name] = {code_point, false};
  }
  const auto addPairs = [&](const char* pairs, bool needs_semicolon) {
    std::istringstream stream(pairs);
    while (stream >> name >> std::hex >> code_point) entities[name] = {code_point, needs_semicolon};
  };
  addPairs(kMarkupNames, false);
  addPairs(kOtherNames, true);
  return entities;
}

const Entity* findEntity(const std::string& name) {
  static const std::map<std::string, Entity> entities = buildEntities();
  const auto it = entities.find(name);
  return it == entities.end() ? nullptr : &it->second;
}

/// What stands behind an '&': "#" and digits, or a name, and whether a semicolon closes it.
struct Reference {
  bool is_number = false;
  std::uint32_t number = 0;
  std::string name;
  bool has_semicolon = false;
  std::int32_t length = 0;  ///< of all of it, from the '&' on
};

int toDigit(char16_t unit, bool is_hex) {
  if (unit >= u'0' && unit <= u'9') return unit - u'0';
  if (is_hex && unit >= u'a' && unit <= u'f') return unit - u'a' + 10;
  if (is_hex && unit >= u'A' && unit <= u'F') return unit - u'A' + 10;
  return -1;
}

/// Reads "#233;" or "#xe9;" at `begin`, behind the '&'.
std::optional<Reference> readNumber(const icu::UnicodeString& text, std::int32_t begin) {
  Reference reference;
  reference.is_number = true;
  std::int32_t at = begin + 1;
  const bool is_hex = text.charAt(at) == u'x' || text.charAt(at) == u'X';
  if (is_hex) ++at;
  const std::int32_t first_digit = at;
  for (int digit = 0; (digit = toDigit(text.charAt(at), is_hex)) >= 0; ++at) {
    // Saturates: everything from 0x110000 on means the same.
    reference.number = std::min<std::uint32_t>(
        reference.number * (is_hex ? 16U : 10U) + static_cast<std::uint32_t>(digit), 0x110000U);
  }
  if (at == first_digit) return std::nullopt;
  reference.has_semicolon = text.charAt(at) == u';';
  reference.length = at + (reference.has_semicolon ? 1 : 0) - begin + 1;
  return reference;
}

bool isAsciiAlphanumeric(char16_t unit) {
  return (unit >= u'0' && unit <= u'9') || (unit >= u'a' && unit <= u'z') ||
         (unit >= u'A' && unit <= u'Z');
}

std::optional<Reference> readReference(const icu::UnicodeString& text, std::int32_t ampersand) {
  const std::int32_t begin = ampersand + 1;
  if (text.charAt(begin) == u'#') return readNumber(text, begin);
  Reference reference;
  std::int32_t at = begin;
  for (; isAsciiAlphanumeric(text.charAt(at)); ++at) {
    reference.name += static_cast<char>(text.charAt(at));
  }
  if (reference.name.empty()) return std::nullopt;
  reference.has_semicolon = text.charAt(at) == u';';
  reference.length = at + (reference.has_semicolon ? 1 : 0) - ampersand;
  return reference;
}

bool isNonCharacter(std::uint32_t number) {
  return (number >= 0xfdd0 && number <= 0xfdef) || (number & 0xfffe) == 0xfffe;
}

bool isDroppedControl(std::uint32_t number) {
  return (number < 0x20 && number != '\t' && number != '\n' && number != '\f' && number != '\r') ||
         number == 0x7f;
}

icu::UnicodeString decodeNumber(std::uint32_t number) {
  if (number == 0 || U_IS_SURROGATE(number) || number > 0x10ffff)
    return icu::UnicodeString(UChar32{0xfffd});
  if (isDroppedControl(number) || isNonCharacter(number)) return {};
  return icu::UnicodeString(decodeWindows1252(static_cast<UChar32>(number)));
}

/// Replaces each reference for which `decode` says what it stands for, and how long it is.
template <typename Decode>
icu::UnicodeString replaceReferences(const icu::UnicodeString& text, const Decode& decode) {
  icu::UnicodeString result;
  std::int32_t done = 0;
  for (std::int32_t at = 0; (at = text.indexOf(u'&', done)) >= 0;) {
    result.append(text, done, at - done);
    std::optional<Reference> reference = readReference(text, at);
    std::optional<icu::UnicodeString> decoded;
    if (reference) decoded = decode(*reference);
    result.append(decoded ? *decoded : icu::UnicodeString(u'&'));
    done = at + (decoded ? reference->length : 1);
  }
  return result.append(text, done, text.length() - done);
}

/// Shortens the reference to the longest beginning of its name that needs no semicolon.
const Entity* findByBeginning(Reference& reference) {
  const auto begin_of_name = reference.length - (reference.has_semicolon ? 1 : 0) -
                             static_cast<std::int32_t>(reference.name.size());
  for (std::size_t size = reference.name.size(); size >= 2; --size) {
    const Entity* const entity = findEntity(reference.name.substr(0, size));
    if (!entity || entity->needs_semicolon) continue;
    reference.length = begin_of_name + static_cast<std::int32_t>(size);
    return entity;
  }
  return nullptr;
}

/// What a name in capitals stands for, if the name in small letters stands for something.
std::optional<icu::UnicodeString> decodeCapitals(const std::string& name) {
  std::string lower_name;
  for (const char character : name) {
    if (character >= 'a' && character <= 'z') return std::nullopt;
    lower_name += static_cast<char>(u_tolower(character));
  }
  const Entity* const entity = findEntity(lower_name);
  if (!entity) return std::nullopt;
  return icu::UnicodeString(entity->code_point).toUpper(icu::Locale::getRoot());
}

}  // namespace

icu::UnicodeString unescapeHtml(const icu::UnicodeString& text) {
  return replaceReferences(text, [](Reference& reference) -> std::optional<icu::UnicodeString> {
    if (reference.is_number) return decodeNumber(reference.number);
    const Entity* entity = reference.has_semicolon ? findEntity(reference.name) : nullptr;
    if (!entity) entity = findByBeginning(reference);
    if (!entity) return std::nullopt;
    return icu::UnicodeString(entity->code_point);
  });
}

icu::UnicodeString unescapeClearHtml(const icu::UnicodeString& text) {
  return replaceReferences(text, [](Reference& reference) -> std::optional<icu::UnicodeString> {
    if (!reference.has_semicolon) return std::nullopt;
    // An unescaped semicolon would look like the end of another reference.
    if (reference.is_number && reference.number == ';') return std::nullopt;
    if (reference.is_number) return decodeNumber(reference.number);
    if (const Entity* entity = findEntity(reference.name)) {
      return icu::UnicodeString(entity->code_point);
    }
    return decodeCapitals(reference.name);
  });
}

}  // namespace tsg::language
