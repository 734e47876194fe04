// Khronos' glTF validator on a file: node validate_gltf.js VALIDATOR FILE
// prints its report as JSON.
'use strict';

const fs = require('fs');
const [validator, file] = process.argv.slice(2);
require(validator)
    .validateBytes(new Uint8Array(fs.readFileSync(file)), {maxIssues: 0})
    .then((report) => console.log(JSON.stringify(report)));
