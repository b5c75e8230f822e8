#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Writes the type stubs of cv2.surgtrack, misc/python/stubs/cv2/surgtrack.pyi: what there is and in which order arguments and results
come from the built module, types and documentation from the module's headers. With --check it only says whether the file is up to date."""

import argparse
import keyword
import os
import re
import sys
import textwrap

from cv2 import surgtrack

HERE = os.path.dirname(os.path.abspath(__file__))
OUTPUT = os.path.join(HERE, 'stubs', 'cv2', 'surgtrack.pyi')
HEADERS = os.path.join(HERE, '..', '..', 'include', 'opencv2')

ARRAY, DOUBLES = 'NDArray[Any]', 'NDArray[np.float64]'
INPUTS = {
    'bool': 'bool', 'int': 'int', 'int64': 'int', 'size_t': 'int', 'uchar': 'int', 'double': 'float', 'float': 'float',
    'String': 'str', 'std::string': 'str', 'void': 'None',
    'InputArray': ARRAY, 'OutputArray': ARRAY, 'InputOutputArray': ARRAY, 'Mat': ARRAY,
    'Point': 'Tuple[int, int]', 'Point2f': 'Tuple[float, float]', 'Point2d': 'Tuple[float, float]', 'Size': 'Tuple[int, int]',
    'Point3f': 'Tuple[float, float, float]', 'Point3d': 'Tuple[float, float, float]', 'Vec3i': 'Tuple[int, int, int]', 'Vec3d': 'Tuple[float, float, float]',
    'Rect': 'Tuple[int, int, int, int]', 'Rect2d': 'Tuple[float, float, float, float]', 'Scalar': '_Sequence[float]',
}
NUMERIC = re.compile(r'(int|uchar|float|double|Point\w*|Rect\w*|Size|Vec\w+)$')   # a std::vector of these is returned as an array
HEADER = '''# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
# Made by misc/python/make_stubs.py: do not edit.
"""%s"""

from typing import Any, Optional, Sequence as _Sequence, Tuple, Union, overload

import numpy as np
from numpy.typing import NDArray

'''


class Failure(Exception):
    """The line the user gets."""


class Declaration:
    """A class, enumerator, property or function of a header; `scope` names the classes around it."""

    def __init__(self, kind, scope, name, doc, **details):
        self.kind, self.scope, self.name, self.doc = kind, scope, name, doc
        self.__dict__.update(details)

    def path(self):
        return '.'.join(self.scope + [self.name])


TOKEN = re.compile(r'''
    (?P<after>//!<[^\n]*) | (?P<line>//![^\n]*) | (?P<block>/\*\*.*?\*/) | (?P<comment>//[^\n]*|/\*.*?\*/|\#(?:\\\n|[^\n])*)
    | (?P<exported>(?:class|struct)\s+CV_EXPORTS_W\w*\s+(?P<class>\w+)[^;{]*\{)
    | (?P<enum>enum\s+(?P<enum_name>\w+)\s*\{)
    | (?P<property>CV_PROP(?P<rw>_RW)?\s+(?P<type>[^;]+?)\s+(?P<prop>\w+)\s*;)
    | (?:CV_WRAP|CV_EXPORTS_W|CV_(?:WRAP|EXPORTS)_AS\((?P<alias>\w+)\))\s+(?P<function>[^;{]*\))\s*(?:const)?\s*(?:=\s*0\s*)?(?=[;{])
    | (?P<enumerator>\b[A-Z][A-Z0-9_]+\b)\s*(?=[=,}])
    | (?P<open>\{) | (?P<close>\}) | (?P<end>;)''', re.DOTALL | re.VERBOSE)


def clean(text):
    """Doxygen to a docstring."""
    lines = [re.sub(r'^\s*(/\*\*|//!<?)\s?|\s*\*/\s*$', '', line).rstrip() for line in text.split('\n')]
    if lines[1:] and all(re.match(r'\s*\*', line) for line in lines[1:] if line):
        lines = lines[:1] + [re.sub(r'^\s*\*\s?', '', line) for line in lines[1:]]
    text = '\n'.join([lines[0].strip()] + textwrap.dedent('\n'.join(lines[1:])).split('\n'))
    if '@{' in text or '@}' in text or '@addtogroup' in text:
        return ''
    text = re.sub(r'\s*@(param(?:\[\w+\])?|return|throws)\s+', '\n@\\1 ', text)
    before, at, after = text.partition('\n@')
    text = before.strip() + '\n\n' * bool(before.strip()) + ('@' if at else '') + after
    for pattern, replacement in ((r'@brief\s+', ''), (r'@param(?:\[\w+\])?\s+(\w+(?:, \w+)*)\s*', r'\1: '), (r'@return ', 'Returns: '),
                                 (r'@throws cv::Exception', 'Raises cv2.error'), (r'@cite\s+(\w+)', r'[\1]'), (r'@p\s+', ''),
                                 (r'\bcv::surgtrack::', ''), (r'\bcv::', 'cv2.'), (r'(\w)::(?=\w)', r'\1.'), (r'[ \t]+(?=\n|$)', '')):
        text = re.sub(pattern, replacement, text)
    return text.strip().replace('\\', '\\\\').replace('"""', "'''")


def split_arguments(text):
    """At the commas that are not within brackets."""
    parts, depth = [''], 0
    for c in text:
        depth += (c in '<(') - (c in '>)')
        if c == ',' and depth == 0:
            parts.append('')
        else:
            parts[-1] += c
    return [' '.join(part.split()) for part in parts if part.strip()]


def parse_function(text, scope, doc):
    head, _, rest = text.partition('(')
    words = re.sub(r'\b(static|virtual|inline|explicit)\b', '', head).split()
    arguments = {}
    for argument in split_arguments(rest.rsplit(')', 1)[0]):
        declared, _, default = argument.partition('=')
        match = re.match(r'(?P<type>.*?)\s*(?P<name>\w+)$', declared.replace('CV_OUT', '').replace('CV_IN_OUT', '').strip())
        name = match.group('name')
        arguments[name + '_' * keyword.iskeyword(name)] = (match.group('type'), default.strip())   # as the binding has it
    return Declaration('function', scope, words[-1], doc, returns=' '.join(words[:-1]), arguments=arguments, static=bool(re.search(r'\bstatic\b', head)))


def parse(header):
    """What a header declares for Python."""
    with open(header) as file:
        text = file.read()
    found, scopes, doc, known = [], [], '', 0
    for token in TOKEN.finditer(text):
        scope = [name for name in scopes if name and not name.startswith('enum ')]
        if token.group('line'):
            doc = (doc + '\n' if doc else '') + token.group('line')
        elif token.group('block'):
            doc = token.group('block')
        elif token.group('after'):
            if found and '\n' not in text[found[-1].end:token.start()]:
                found[-1].doc = found[-1].doc or clean(token.group('after'))
        elif token.group('exported'):
            found.append(Declaration('class', scope, token.group('class'), clean(doc)))
            scopes.append(token.group('class'))
        elif token.group('enum'):
            scopes.append('enum ' + token.group('enum_name'))
        elif token.group('enumerator'):
            if scopes and (scopes[-1] or '').startswith('enum '):
                found.append(Declaration('enumerator', scope, token.group('enumerator'), ''))
        elif token.group('property'):
            found.append(Declaration('property', scope, token.group('prop'), clean(doc), type=token.group('type'), writable=bool(token.group('rw'))))
        elif token.group('function'):
            found.append(parse_function(token.group('function'), scope, clean(doc)))
            found[-1].name = token.group('alias') or found[-1].name
        elif token.group('open'):
            scopes.append(None)
        elif token.group('close') and scopes:
            scopes.pop()
        if len(found) > known:
            found[-1].end = token.end()
        known = len(found)
        if not token.group('line') and not token.group('block') and not token.group('comment'):
            doc = ''
    return found


class Types:
    """C++ types as Python has them, as arguments and as results."""

    def __init__(self, classes):
        self.classes = classes

    def name(self, cpp, scope, result):
        cpp = re.sub(r'\bconst\b|&|\bcv::', '', cpp).strip()
        if cpp in INPUTS:
            return INPUTS[cpp]
        if re.match(r'Matx\d+d$', cpp):
            return DOUBLES
        inner = re.match(r'std::vector<\s*(.*?)\s*>$', cpp)
        if inner and result:
            if NUMERIC.match(inner.group(1)):
                return DOUBLES if inner.group(1) == 'double' else ARRAY
            return 'Tuple[%s, ...]' % self.name(inner.group(1), scope, result)
        if inner:
            element = inner.group(1)
            items = '_Sequence[%s]' % self.name(element, scope, result)
            if element == 'double' or re.match(r'Matx\d+d$', element):
                return 'Union[%s, %s]' % (items, DOUBLES)
            return 'Union[%s, %s]' % (items, ARRAY) if NUMERIC.match(element) else items
        inner = re.match(r'Ptr<\s*(\w+)\s*>$', cpp)
        cpp = (inner.group(1) if inner else cpp).replace('::', '.')
        for depth in range(len(scope), -1, -1):
            path = '.'.join(scope[:depth] + [cpp])
            if path in self.classes:
                return path
        raise Failure('%s: no Python type is known for it, expected one in INPUTS' % cpp)


def documented(indent, text):
    if not text:
        return []
    lines = text.split('\n')
    if len(lines) == 1:
        return ['%s"""%s"""' % (indent, text)]
    return ['%s"""%s' % (indent, lines[0])] + [(indent + line) if line else '' for line in lines[1:]] + ['%s"""' % indent]


def native(scope, name):
    """What the built module has of that name."""
    item = surgtrack
    for part in scope + [name]:
        if not hasattr(item, part):
            raise Failure('cv2.surgtrack.%s: the headers have it, but not the built module; expected a build of these headers' % '.'.join(scope + [name]))
        item = getattr(item, part)
    return item


def signature(declaration, types):
    """Arguments and result of a function, from the first line of the built module's documentation."""
    scope, arguments = declaration.scope, declaration.arguments
    for line in (native(scope, declaration.name).__doc__ or '').split('\n'):
        match = re.match(r'%s\((.*)\) -> (.*)$' % declaration.name, line)
        if match and set(re.findall(r'\w+', ' '.join(match.groups()))) - {'retval', 'None'} == set(arguments):
            break
    else:
        raise Failure('cv2.surgtrack.%s: the built module and the headers have other arguments; expected a build of these headers' % declaration.path())
    given = []
    required = re.findall(r'\w+', match.group(1).partition('[')[0])
    for name in re.findall(r'\w+', match.group(1)):
        kind = types.name(arguments[name][0], scope, False)
        optional = name not in required
        if optional and (arguments[name][0] == 'OutputArray' or 'Ptr<' in arguments[name][0]):
            kind = 'Optional[%s]' % kind
        given.append('%s: %s%s' % (name, kind, ' = ...' if optional else ''))
    results = [types.name(declaration.returns if name == 'retval' else arguments[name][0], scope, True)
               for name in re.findall(r'\w+', match.group(2)) if name != 'None']
    return given, 'None' if not results else results[0] if len(results) == 1 else 'Tuple[%s]' % ', '.join(results)


def write_function(declaration, types, overloaded):
    indent = '    ' * len(declaration.scope)
    lines = [indent + '@overload'] if overloaded else []
    constructor = declaration.scope and declaration.name == declaration.scope[-1]
    if constructor:
        given, result, name = ['%s: %s' % (n, types.name(a[0], declaration.scope, False)) for n, a in declaration.arguments.items()], 'None', '__init__'
    else:
        given, result = signature(declaration, types)
        name = declaration.name
    if declaration.scope and not declaration.static:
        given = ['self'] + given
    if declaration.static:
        lines.append(indent + '@staticmethod')
    head = '%sdef %s(%s) -> %s:' % (indent, name, ', '.join(given), result)
    doc = documented(indent + '    ', declaration.doc)
    return lines + ([head] + doc + [indent + '    ...'] if doc else [head + ' ...'])


def write_class(declaration, declarations, types):
    indent = '    ' * len(declaration.scope)
    path = declaration.scope + [declaration.name]
    body = []
    members = [d for d in declarations if d.scope == path]
    for member in sorted(members, key=lambda d: d.kind != 'class'):   # nested classes first: others use them
        if member.kind == 'class':
            body += write_class(member, declarations, types)
        elif member.kind == 'property':
            kind = types.name(member.type, path, True)
            native(path, member.name)
            if member.writable:
                body += ['%s    %s: %s' % (indent, member.name, kind)] + documented(indent + '    ', member.doc)
            else:
                doc = documented(indent + '        ', member.doc)
                head = '%s    def %s(self) -> %s:' % (indent, member.name, kind)
                body += [indent + '    @property'] + ([head] + doc + [indent + '        ...'] if doc else [head + ' ...'])
        elif member.kind == 'function':
            body += write_function(member, types, sum(m.kind == 'function' and m.name == member.name for m in members) > 1)
    native(declaration.scope, declaration.name)
    return ['%sclass %s:' % (indent, declaration.name)] + documented(indent + '    ', declaration.doc) + (body or [indent + '    ...']) + ['']


def make():
    texts = []
    for name in ('surgtrack.hpp', 'surgtrack/lab.hpp'):   # tracking, and what is around it
        with open(os.path.join(HEADERS, name)) as file:
            texts.append(file.read())
    text = ''.join(texts)
    overview = clean(re.sub(r'@defgroup \w+ ', '', re.search(r'/\*\*(.*?)\*/', text, re.DOTALL).group(1)))
    declarations = [d for name in re.findall(r'#include "opencv2/(surgtrack/\w+\.hpp)"', text) for d in parse(os.path.join(HEADERS, name))]
    types = Types({d.path() for d in declarations if d.kind == 'class'})
    lines = []
    for d in declarations:
        if d.kind == 'enumerator':
            name = '_'.join(d.scope + [d.name])
            native([], name)
            lines += ['%s: int' % name] + documented('', d.doc)
    lines.append('')
    for d in declarations:
        if d.scope:
            continue
        if d.kind == 'class':
            lines += write_class(d, declarations, types)
        elif d.kind == 'function':
            lines += write_function(d, types, sum(o.kind == 'function' and not o.scope and o.name == d.name for o in declarations) > 1) + ['']
    unknown = ['.'.join(d.scope + [d.name, name]) for d in declarations if d.kind == 'class' for name in vars(native(d.scope, d.name))
               if not name.startswith('_') and not any(m.scope == d.scope + [d.name] and m.name == name for m in declarations)]
    known = {d.name for d in declarations if not d.scope} | {'_'.join(d.scope + [d.name]) for d in declarations}
    flat = {re.sub(r'(?<=[a-z])(?=[A-Z])', '_', '_'.join(d.scope)).upper() + '_' + d.name for d in declarations if d.kind == 'enumerator' and d.scope}
    unknown += sorted(name for name in dir(surgtrack) if not name.startswith('_') and name not in known | flat)
    if unknown:
        raise Failure('cv2.surgtrack.%s: the built module has it, but not the headers; expected a build of these headers' % unknown[0])
    return HEADER % overview + re.sub(r'\n{3,}', '\n\n', '\n'.join(lines)).rstrip() + '\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--check', action='store_true', help='write nothing; exit code 1 if the file is not what would be written')
    args = parser.parse_args()
    text = make()
    if args.check:
        with open(OUTPUT) as file:
            if file.read() != text:
                raise Failure('%s is not up to date, run make_stubs.py' % OUTPUT)
        return
    with open(OUTPUT, 'w') as file:
        file.write(text)


if __name__ == '__main__':
    try:
        main()
    except Failure as error:
        sys.exit('make_stubs.py: %s' % error)
