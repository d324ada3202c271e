% Made by varcontact $version.
function [force, status, message] = vc_forces(contact)
%VC_FORCES  Creep forces [Fx Fy Mz] of an elliptic contact; arguments, units and status as in vc_forces.h.
%   contact = [a b G nu Fz f vx vy spin]
%
%   First compile vc_forces.c to a shared library beside this file, as the documentation shows.
if ~libisloaded('vc_forces')
    folder = fileparts(mfilename('fullpath'));
    loadlibrary(fullfile(folder, 'vc_forces'), fullfile(folder, 'vc_forces.h'));
end
out = libpointer('doublePtr', zeros(1, 3));
status = calllib('vc_forces', 'vc_forces', contact, out);
force = out.Value;
message = calllib('vc_forces', 'vc_message', status);
if nargout < 2 && status ~= 0
    if status < 0
        error('varcontact:vc_forces', '%s', message);
    end
    warning('varcontact:vc_forces', '%s', message);
end
end
